"""Margins of three sampled loops by python-control 0.10.

Writes margins_reference.csv next to this file: `python margins_reference.py` (python-control, SciPy).
The plant is yaw = gain/((tau s + 1) s) times steering, held from tick to tick and late by whole
samples; the controller is the PID's law in 1/z (backward Euler). `disk_margins` has zero skew.
"""

import pathlib

import control as ct
import numpy as np

CASES = [
    # gain, tau, late samples, sample time, kp, ki, kd, filter time
    (4.0, 0.10, 0, 0.01, 1.2, 0.6, 0.05, 0.02),
    (4.0, 0.10, 3, 0.01, 1.2, 0.6, 0.05, 0.02),
    (8.0, 0.30, 2, 0.02, 0.7, 1.1, 0.15, 0.03),
]


def main():
    rows = ["gain,tau,late,sample_time,kp,ki,kd,filter,gain_margin_db,phase_margin_deg,modulus,disk"]
    for case in CASES:
        gain, tau, late, ts, kp, ki, kd, tf = case
        plant = ct.sample_system(ct.tf([gain], [tau, 1.0, 0.0]), ts, "zoh")
        z = ct.tf([1.0, 0.0], [1.0], ts)
        difference = (z - 1) / z
        law = kp + ki * ts / difference + kd * difference / (tf * difference + ts)
        loop = ct.ss(ct.minreal(plant * law / z**late, verbose=False))
        gm, pm = ct.margin(loop)[:2]
        # Zero skew; the grid ends just below half the sample rate.
        omega = np.geomspace(0.02, 0.9999 * np.pi / ts, 200_000)
        disk = ct.disk_margins(loop, omega, skew=0.0)[0]
        modulus = np.abs(1 + loop(np.exp(1j * omega * ts))).min()
        values = [*case, 20 * np.log10(gm), pm, modulus, disk]
        rows.append(",".join(f"{float(v):.9g}" for v in values))
    here = pathlib.Path(__file__).with_name("margins_reference.csv")
    here.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
