"""Xsens Xbus with MTData2: MTi-1, MTi-10, MTi-100 and MTi-600 series.

From bytes to samples, a file a layer: ``framer`` finds messages among bytes, ``mtdata2`` finds
items in a measurement, ``readings`` turns items into channels, ``sampler`` turns messages into
samples on the device's clock (``ticks``), ``session`` brings a device into measurement, and
``codec`` is the whole. ``peripheral`` is the device's side.

Facts are those of Xsens' MT Low Level Communication Protocol, MT0101P revision 2020.A.
"""
