"""Writes MDF files with asammdf, and the samples that asammdf reads from them."""

import itertools
import sys
from pathlib import Path

import numpy as np
from asammdf import MDF, Signal, Source
from asammdf.blocks import v4_constants as v4

from common import Expected

folder = Path(sys.argv[1])
expected = Expected(folder)
random = np.random.default_rng(16)
rows = 5000
time = np.cumsum(random.uniform(0.005, 0.015, rows))
slow = time[::10].copy()


def signals(old):
    ints = [np.uint8, np.int8, np.uint16, np.int16, np.uint32, np.int32, np.uint64, np.int64]
    for kind in ints:
        info = np.iinfo(kind)
        # Beyond 2^53 numbers of 64 bits are rounded.
        low, high = max(info.min, -(2**52)), min(info.max, 2**52)
        yield Signal(random.integers(low, high, rows, dtype=kind), time, name=kind.__name__)
    for kind in [np.float32, np.float64]:
        yield Signal(random.normal(size=rows).astype(kind), time, name=kind.__name__, unit="rad")
    yield Signal(
        random.integers(-500, 500, rows, dtype=np.int16),
        time,
        name="linear",
        unit="deg",
        conversion={"a": 0.1, "b": -3.7},
    )
    if old:
        return
    yield Signal(
        random.integers(0, 1000, rows, dtype=np.uint16),
        time,
        name="rational",
        conversion={"P1": 0.0, "P2": 2.0, "P3": 1.0, "P4": 0.0, "P5": 1.0, "P6": 7.0},
    )
    raw = random.integers(0, 60, rows, dtype=np.uint8)
    table = {f"{k}_{n}": v for n, (r, p) in enumerate([(0, 1.5), (20, 3.25), (60, -7.0)]) for k, v in [("raw", r), ("phys", p)]}
    yield Signal(raw, time, name="table", conversion={**table, "interpolation": True})
    yield Signal(
        random.normal(size=rows),
        time,
        name="invalid",
        invalidation_bits=random.random(rows) < 0.1,
    )
    yield Signal(random.integers(0, 2**15, rows).astype(">u2"), time, name="big_endian")


def write(name, version, compression):
    mdf = MDF(version=version)
    mdf.append(list(signals(version < "4")), acq_name="fast", comment="fast", common_timebase=True)
    mdf.append([Signal(np.sin(slow), slow, name="slow", unit="m/s")], acq_name="slow", comment="slow")
    path = folder / name
    mdf.save(path, overwrite=True, compression=compression)
    mdf.close()
    with MDF(path) as read:
        for group, content in enumerate(read.groups):
            for channel in content.channels:
                if channel.name in ("time", "t"):
                    continue
                # Else samples that are invalid are left out, with their times.
                signal = read.get(channel.name, group=group, ignore_invalidation_bits=True)
                values = signal.samples.astype(float)
                if signal.invalidation_bits is not None:
                    values[np.asarray(signal.invalidation_bits, dtype=bool)] = np.nan
                # Interpolated by another order of operations.
                more = {"tolerance": 4e-15} if channel.name == "table" else {}
                expected.add(name, channel.name, signal.timestamps, values, **more)


for version, compression in itertools.product(["4.00", "4.10", "4.20"], [0, 1, 2]):
    write(f"{version}-{compression}.mf4", version, compression)
write("3.30.mdf", "3.30", 0)


def bus(name, compression):
    """Frames of two buses with messages of databases."""
    import cantools

    dbc = (Path(sys.argv[2])).read_text()
    (folder / "bus.dbc").write_text(dbc)
    database = cantools.database.load_string(dbc, "dbc")
    messages = [m for m in database.messages if m.length == 8 and m.signals][:6]
    count = 4000
    times = np.cumsum(random.uniform(1e-4, 1e-3, count))
    which = random.integers(0, len(messages), count)
    data = random.integers(0, 256, (count, 8), dtype=np.uint8)
    kinds = [
        ("CAN_DataFrame.BusChannel", "<u1"),
        ("CAN_DataFrame.ID", "<u4"),
        ("CAN_DataFrame.IDE", "<u1"),
        ("CAN_DataFrame.DLC", "<u1"),
        ("CAN_DataFrame.DataLength", "<u1"),
        ("CAN_DataFrame.DataBytes", "(8,)u1"),
    ]
    frames = np.zeros(count, dtype=kinds)
    frames["CAN_DataFrame.BusChannel"] = 1
    frames["CAN_DataFrame.ID"] = [messages[k].frame_id for k in which]
    frames["CAN_DataFrame.DLC"] = frames["CAN_DataFrame.DataLength"] = 8
    frames["CAN_DataFrame.DataBytes"] = data
    source = Source("bus", "bus", "", v4.SOURCE_BUS, v4.BUS_TYPE_CAN)
    mdf = MDF(version="4.10")
    mdf.append(
        [Signal(frames, times, name="CAN_DataFrame", source=source)],
        acq_name="CAN1",
        acq_source=source,
        common_timebase=True,
    )
    mdf.save(folder / name, overwrite=True, compression=compression)
    mdf.close()
    for k, message in enumerate(messages):
        own = which == k
        decoded = [message.decode(bytes(row), decode_choices=False, scaling=True) for row in data[own]]
        for signal in message.signals:
            values = np.array([float(row[signal.name]) for row in decoded])
            expected.add(name, f"{message.name}.{signal.name}", times[own], values, dbc="bus.dbc")


if len(sys.argv) > 2:
    for compression in [0, 2]:
        bus(f"bus-{compression}.mf4", compression)
expected.write()
