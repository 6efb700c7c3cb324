"""The linear model of bare.c as pythonfmu has one write it."""
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

A = ((0.95, 0.05, 0.0, 0.0), (-0.05, 0.95, 0.02, 0.0), (0.0, 0.0, 0.8, 0.1), (0.0, 0.0, -0.1, 0.8))
B = (0.01, 0.02, 0.03, 0.01)
C = (1.0, 0.5, 0.25, 0.125)


class Linear(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.x = (0.0, 0.0, 0.0, 0.0)
        self.u = 1.0
        self.y = 0.0
        self.register_variable(
            Real("u", causality=Fmi2Causality.input, variability=Fmi2Variability.continuous)
        )
        self.register_variable(
            Real("y", causality=Fmi2Causality.output, variability=Fmi2Variability.continuous)
        )

    def do_step(self, current_time, step_size):
        x0, x1, x2, x3 = self.x
        u = self.u
        self.x = x = tuple(
            a[0] * x0 + a[1] * x1 + a[2] * x2 + a[3] * x3 + b * u for a, b in zip(A, B)
        )
        self.y = C[0] * x[0] + C[1] * x[1] + C[2] * x[2] + C[3] * x[3]
        return True
