"""Writes bus logs with python-can, and the signals that cantools decodes from their frames."""

import sys
from pathlib import Path

import can
import cantools
import numpy as np

from common import Expected

folder = Path(sys.argv[1])
expected = Expected(folder)
random = np.random.default_rng(16)

# Every length in both byte orders and signs, with whole and fractional factors, multiplexed and floating.
lines = ['VERSION ""', "", "BU_: A", ""]
for number, (order, sign) in enumerate([(1, "+"), (1, "-"), (0, "+"), (0, "-")]):
    for k, length in enumerate([1, 3, 8, 11, 16, 24, 31, 32, 33, 47, 53]):
        lines.append(f"BO_ {100 + 20 * number + k} M{number}_{length}: 8 A")
        offset = int(random.integers(0, 65 - length))
        start = offset if order else 8 * (offset // 8) + 7 - offset % 8
        factor, constant = [("1", "0"), ("0.1", "-40"), ("2", "7"), ("0.0625", "0.5")][k % 4]
        lines.append(f' SG_ S{number}_{length} : {start}|{length}@{order}{sign} ({factor},{constant}) [0|0] "deg" A')
        lines.append("")
lines += [
    "BO_ 2147484672 Multiplexed: 8 A",
    ' SG_ Always : 56|8@1+ (1,0) [0|0] "" A',
    ' SG_ Mode M : 0|2@1+ (1,0) [0|3] "" A',
    ' SG_ First m0 : 8|16@1- (0.01,0) [0|0] "m/s" A',
    ' SG_ Second m1 : 8|12@1+ (1,0) [0|0] "" A',
    ' SG_ Third m1 : 24|8@1+ (1,0) [0|0] "" A',
    "",
    "BO_ 900 Floats: 12 A",
    ' SG_ Single : 0|32@1- (1,0) [0|0] "" A',
    ' SG_ Double : 32|64@1- (0.5,1) [0|0] "" A',
    "",
    "BO_ 901 Long: 64 A",
    ' SG_ Far : 400|17@1- (0.001,0) [0|0] "" A',
    ' SG_ Back : 455|33@0+ (1,0) [0|0] "" A',
    "",
    'CM_ SG_ 901 Far "A comment',
    'BO_ 902 None: 8 A";',
    "SIG_VALTYPE_ 900 Single : 1;",
    "SIG_VALTYPE_ 900 Double : 2;",
    "",
]
text = "\n".join(lines)
(folder / "all.dbc").write_text(text)
database = cantools.database.load_string(text, "dbc")

count = 6000
times = np.round(1_700_000_000 + np.cumsum(random.uniform(1e-4, 1e-3, count)), 6)
which = random.integers(0, len(database.messages), count)
frames = []
for time, k in zip(times, which):
    message = database.messages[k]
    data = random.integers(0, 256, message.length, dtype=np.uint8)
    if message.name == "Multiplexed":
        data[0] &= 0xFD
    if message.name == "Floats":
        values = random.normal(size=2)
        data = np.frombuffer(message.encode({"Single": values[0], "Double": values[1]}), np.uint8)
    frames.append((float(time), message, bytes(data)))


def write(name, logger):
    for time, message, data in frames:
        logger.on_message_received(
            can.Message(
                timestamp=time,
                arbitration_id=message.frame_id,
                is_extended_id=message.is_extended_frame,
                is_fd=message.length > 8,
                data=data,
                channel=0 if name.endswith(".asc") else "can0",
                is_rx=True,
            )
        )
    logger.stop()


write("bus.log", can.CanutilsLogWriter(folder / "bus.log"))
write("bus.asc", can.ASCWriter(folder / "bus.asc"))
# Times as the texts have them, read by python-can.
for name, reader in [("bus.log", can.CanutilsLogReader), ("bus.asc", can.ASCReader)]:
    read = list(reader(folder / name)) if name != "bus.asc" else list(reader(folder / name, relative_timestamp=True))
    assert len(read) == count, (name, len(read))
    signals = {}
    for frame, (_, message, data) in zip(read, frames):
        assert bytes(frame.data) == data
        decoded = message.decode(data, decode_choices=False, scaling=True)
        for signal, value in decoded.items():
            signals.setdefault((message.name, signal), []).append((frame.timestamp, float(value)))
    for (message, signal), samples in signals.items():
        time, values = zip(*samples)
        expected.add(name, signal, time, values, dbc="all.dbc", message=message)
expected.write()
