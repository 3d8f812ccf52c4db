import numpy as np
import pytest

from gaitway.simulation import Constant, Person, stream


def test_one_seed_is_one_person():
    assert Person.draw(7) == Person.draw(7)
    assert Person.draw(7) != Person.draw(8)


def test_people_are_of_human_size_and_pace():
    people = [Person.draw(seed) for seed in range(200)]
    heights_m = np.array([person.height_m for person in people])
    paces = np.array([person.pace for person in people])
    assert heights_m.min() < 1.55
    assert heights_m.max() > 1.85
    assert np.all((heights_m >= 1.5) & (heights_m <= 1.9))
    assert np.all((paces >= 0.75) & (paces <= 1.25))
    assert paces.mean() == pytest.approx(1.0, abs=0.03)


def test_purposes_draw_different_numbers_of_one_seed():
    assert stream(1, "sensor").random() == stream(1, "sensor").random()
    assert stream(1, "sensor").random() != stream(1, "person").random()
    assert stream(1, "sensor").random() != stream(2, "sensor").random()


def test_tremor_has_the_amplitude_and_frequency_of_the_person():
    person = Person.draw(3)
    t_s = np.arange(0.0, 20.0, 0.002)
    angles = person.tremor(Constant(1.0), np.random.default_rng(0))(t_s)[:, 1]
    spectrum = np.abs(np.fft.rfft(angles)) ** 2
    frequencies_hz = np.fft.rfftfreq(len(t_s), 0.002)
    mean_hz = np.sum(frequencies_hz * spectrum) / spectrum.sum()
    assert 0.8 * person.tremor_hz < mean_hz < 1.35 * person.tremor_hz
    assert 0.2 * person.tremor_rad < np.abs(angles).max() < 1.9 * person.tremor_rad
