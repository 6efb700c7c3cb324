"""The linear bicycle that the data sheet of a car gives."""

GRAVITY_MPS2 = 9.81  # the vehicle model's own figure


def bicycle_parameters(p):
    """As CommonRoad's single-track model derives them: mu C_S F_z, with mu C_S = -p_ky1."""
    wheelbase = p.a + p.b
    per_load = p.tire.p_dy1 * (-p.tire.p_ky1 / p.tire.p_dy1)
    return {
        "mass_kg": p.m,
        "yaw_inertia_kgm2": p.I_z,
        "distance_front_m": p.a,
        "distance_rear_m": p.b,
        "cornering_stiffness_front_npr": per_load * p.m * GRAVITY_MPS2 * p.b / wheelbase,
        "cornering_stiffness_rear_npr": per_load * p.m * GRAVITY_MPS2 * p.a / wheelbase,
    }
