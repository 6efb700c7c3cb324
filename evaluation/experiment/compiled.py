"""The published multi-body vehicle, compiled but unmodified.

numba compiles the very code objects of `commonroad-vehicle-models`; what they call is compiled
likewise, and the parameters become nested named tuples, which is what numba takes.
`test_vehicle.py` holds the result against the plain functions.
"""

import types
from collections import namedtuple
from dataclasses import fields, is_dataclass

import numba
import numpy as np
from vehiclemodels import vehicle_dynamics_mb as multi_body
from vehiclemodels.utils import (
    acceleration_constraints,
    steering_constraints,
    tire_model,
    vehicle_dynamics_ks_cog,
)


def with_globals(function, **replaced):
    """The function's own code, compiled, which finds other functions under its global names."""
    scope = {**function.__globals__, **replaced}
    return numba.njit(error_model="numpy")(types.FunctionType(function.__code__, scope, function.__name__))


def module(published):
    """A module of which all functions are compiled; those that call others see these compiled."""
    copy = types.ModuleType(published.__name__)
    for name, member in vars(published).items():
        if isinstance(member, types.FunctionType):
            setattr(copy, name, with_globals(member, **vars(copy)))
    return copy


def vehicle_dynamics():
    """`vehicle_dynamics_mb(state, [steering rate, acceleration], parameters)`, compiled."""
    constraints = {
        name: with_globals(getattr(where, name))
        for where, name in (
            (steering_constraints, "steering_constraints"),
            (acceleration_constraints, "acceleration_constraints"),
        )
    }
    kinematic = with_globals(vehicle_dynamics_ks_cog.vehicle_dynamics_ks_cog, **constraints)
    return with_globals(
        multi_body.vehicle_dynamics_mb,
        vehicle_dynamics_ks_cog=kinematic,
        tireModel=module(tire_model),
        **constraints,
    )


def values(published):
    """All parameters in one array, in the order of the fields; what has no value is left out."""
    return np.array([value for _, value in _walk(published)])


def unpacking(published):
    """A compiled function that makes nested named tuples of [`values`].

    They are made inside of the compiled code because handing them over takes ten times as long as
    a sample of driving.
    """
    scope, count = {}, iter(range(len(values(published))))

    def expression(part):
        members = {}
        for field in fields(part):
            value = getattr(part, field.name)
            if is_dataclass(value) and any(True for _ in _walk(value)):
                members[field.name] = expression(value)
            elif isinstance(value, (int, float)):
                members[field.name] = f"values[{next(count)}]"
        name = type(part).__name__
        scope[name] = namedtuple(name, members)
        return f"{name}({', '.join(members.values())})"

    exec(f"def unpack(values): return {expression(published)}", scope)
    return numba.njit(scope["unpack"])


def _walk(part):
    for field in fields(part):
        value = getattr(part, field.name)
        if is_dataclass(value):
            yield from _walk(value)
        elif isinstance(value, (int, float)):
            yield field.name, float(value)
