"""The tables of ``make accuracy``, and its report with pictures."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import numpy as np
from matplotlib.figure import Figure
from run import Result


def table(results: Sequence[Result]) -> str:
    """Return all results as text."""
    lines = []
    for result in results:
        experiment = result.experiment
        walks = len(next(iter(result.outcomes.values())))
        paper = f"   paper: {experiment.paper}" if experiment.paper else ""
        lines.append(f"\n{experiment.device}: {experiment.name} ({walks} walks){paper}")
        for method, figures in result.figures.items():
            shown = "  ".join(f"{name} {value:.3g}" for name, value in figures.items())
            lines.append(f"  {method:12} {shown}")
        for target, met in result.targets():
            lines.append(f"  {'':12} {'met' if met else 'MISSED'}: {target}")
    told = [(r, target, met) for r in results for target, met in r.targets()]
    if told:
        lines.append(
            f"\ntargets met by the default method: {sum(t[2] for t in told)} of {len(told)}"
        )
        lines += [
            f"  missed: {r.experiment.device}: {r.experiment.name}: {target}"
            for r, target, met in told
            if not met
        ]
    return "\n".join(lines)


def write_report(
    folder: Path, simulated: Sequence[Result], measured: Sequence[Result], why_not: str
) -> None:
    """Write report.md and a picture for each device."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["# Accuracy", ""]
    for title, results in (
        ("Simulated: not measured on people", simulated),
        ("Measured on people", measured),
    ):
        lines += [f"## {title}", ""]
        if not results:
            lines += [f"Left out: {why_not}.", ""]
        for device, group in groupby(results, key=lambda result: result.experiment.device):
            of_device = list(group)
            name = f"{device}{'-people' if of_device[0].experiment.people else ''}.png"
            _draw(of_device).savefig(folder / name, dpi=110)
            lines += [f"### {device}", "", f"![{device}]({name})", "", *_markdown(of_device), ""]
    (folder / "report.md").write_text("\n".join(lines), encoding="utf-8")


def _markdown(results: Sequence[Result]) -> list[str]:
    lines = [
        "| experiment | walks | method | figures | paper | target |",
        "|---|---|---|---|---|---|",
    ]
    for result in results:
        e = result.experiment
        targets = "; ".join(
            f"{text}: {'met' if met else '**missed**'}" for text, met in result.targets()
        )
        for number, (method, figures) in enumerate(result.figures.items()):
            shown = ", ".join(f"{name} {value:.3g}" for name, value in figures.items())
            walks = len(result.outcomes[method])
            paper, aim = (e.paper, targets) if number == 0 else ("", "")
            lines.append(f"| {e.name} | {walks} | {method} | {shown} | {paper} | {aim} |")
    return lines


def _draw(results: Sequence[Result]) -> Figure:
    """Return errors of every walk by method, and how they compare with the sigmas told."""
    figure = Figure(figsize=(11, 1.6 + 0.55 * len(results)), layout="constrained")
    errors, sigmas = figure.subplots(1, 2, width_ratios=[2, 1])
    colours: dict[str, str] = {}
    standardised = []
    for row, result in enumerate(results):
        for place, (method, walks) in enumerate(result.outcomes.items()):
            colour = colours.setdefault(method, f"C{len(colours)}")
            main = [w for walk in walks for w in walk[:1] if w.told is not None]
            error = [100.0 * (o.told - o.true) / o.true if o.true else o.told for o in main]
            height = row + 0.8 * (place + 0.5) / len(result.outcomes) - 0.4
            errors.plot(error, np.full(len(error), height), "o", ms=3, alpha=0.5, color=colour)
            if place == 0:
                standardised += [
                    (o.told - o.true) / o.sigma for walk in walks for o in walk
                    if o.sigma and o.told is not None
                ]  # fmt: skip
    for method, colour in colours.items():
        errors.plot([], [], "o", color=colour, label=method)
    errors.set_yticks(range(len(results)), [r.experiment.name for r in results], fontsize=7)
    errors.invert_yaxis()
    errors.set_xscale("symlog", linthresh=2.0)
    errors.axvline(0.0, color="0.7", lw=0.8)
    errors.set_xlabel("error of each walk, % of the truth")
    errors.legend(fontsize=7)
    sigmas.set_title("default: error over the sigma told", fontsize=9)
    if standardised:
        bins = np.linspace(-4, 4, 33)
        sigmas.hist(np.clip(standardised, -4, 4), bins, density=True, alpha=0.6)
        sigmas.plot(
            bins, np.exp(-0.5 * bins**2) / np.sqrt(2 * np.pi), "k", lw=1, label="as it should be"
        )
        sigmas.legend(fontsize=7)
    return figure
