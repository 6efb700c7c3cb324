"""The published multi-body vehicle, compiled but unmodified.

numba compiles the very code objects of `commonroad-vehicle-models`; what they call is compiled
likewise, and the parameters become nested named tuples, which is what numba takes.
`test_vehicle.py` holds the result against the plain functions.
"""

import types
from collections import namedtuple
from dataclasses import fields, is_dataclass

import numba
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


def parameters(published):
    """Nested named tuples of the parameters; what has no value is left out."""
    values = {}
    for field in fields(published):
        value = getattr(published, field.name)
        if is_dataclass(value):
            values[field.name] = parameters(value)
        elif value is not None:
            values[field.name] = float(value)
    values = {name: value for name, value in values.items() if value != ()}
    return namedtuple(type(published).__name__, values)(**values)
