"""Orders that SLICOT chooses by itself (ctrlsys, IB01AD): arguments FILE SAMPLES BLOCK_ROWS.

FILE holds records of SAMPLES inputs and as many outputs. A line for each: N4SID's choice, MOESP's.
"""

import sys

import ctrlsys
import numpy as np

path, samples, rows = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
for record in np.fromfile(path, dtype="<f8").reshape(-1, 2, samples):
    u, y = (np.asfortranarray(x.reshape(-1, 1)) for x in record)
    # A tolerance below zero requests the largest gap between singular values, SLICOT's own rule.
    orders = [
        ctrlsys.ib01ad(m, "C", "N", "O", "N", "N", rows, 1, 1, u.copy("F"), y.copy("F"), 0.0, -1.0)[0]
        for m in "NM"
    ]
    print(*orders)
