"""Writes Parquet files with pyarrow, and the samples that pyarrow reads from them."""

import datetime
import decimal
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from common import Expected

folder = Path(sys.argv[1])
expected = Expected(folder)
random = np.random.default_rng(16)
rows = 5000
stamps = 1_700_000_000_000_000_000 + np.cumsum(random.integers(9_000_000, 11_000_000, rows))
gaps = random.random(rows) < 0.1


def columns():
    yield "stamp", pa.array(stamps, pa.timestamp("ns"))
    yield "micros", pa.array(stamps // 1000, pa.timestamp("us"))
    yield "of_day", pa.array(np.arange(rows, dtype=np.int32), pa.time32("ms"))
    for name in ["int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"]:
        info = np.iinfo(name)
        low, high = max(info.min, -(2**52)), min(info.max, 2**52)
        yield name, pa.array(random.integers(low, high, rows, dtype=name))
    yield "float", pa.array(random.normal(size=rows).astype(np.float32))
    yield "double", pa.array(random.normal(size=rows))
    yield "nulls", pa.array(random.normal(size=rows), mask=gaps)
    yield "few", pa.array(random.integers(0, 5, rows), mask=gaps)
    yield "bool", pa.array(random.random(rows) < 0.5)
    yield "decimal", pa.array([decimal.Decimal(int(k)).scaleb(-2) for k in range(rows)], pa.decimal128(9, 2))
    yield "all_null", pa.array([None] * rows, pa.float64())
    yield "text", pa.array(["a"] * rows)
    yield "nested", pa.array([{"x": float(k), "list": [1]} for k in range(rows)])


def seconds(value):
    if value is None:
        return float("nan")
    return float(value)


table = pa.table(dict(columns()))
for codec in ["none", "snappy", "gzip", "brotli", "lz4", "zstd"]:
    for version, page in [("1.0", "1.0"), ("2.6", "2.0")]:
        name = f"{codec}-{page}.parquet"
        own = table if version == "2.6" else table.drop(["uint32"])
        pq.write_table(
            own,
            folder / name,
            compression=codec,
            version="2.6",
            data_page_version=page,
            row_group_size=1700,
            data_page_size=4000,
            store_decimal_as_integer=True,
        )
        read = pq.read_table(folder / name)
        time = read["stamp"].cast(pa.int64()).to_numpy() / 1e9
        scales = {"stamp": 1e9, "micros": 1e6, "of_day": 1e3}
        for column in read.column_names:
            if column in ("text", "nested"):
                continue
            data = read[column]
            if column in scales:
                data = data.cast(pa.int32() if column == "of_day" else pa.int64())
            values = [seconds(x) / scales.get(column, 1) for x in data.to_pylist()]
            expected.add(name, column, time, values, clock="stamp")
        nested = [float(x["x"]) for x in read["nested"].to_pylist()]
        expected.add(name, "nested.x", time, nested, clock="stamp")
expected.write()
