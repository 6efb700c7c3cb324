"""The connections of the closed loop, as in the FMUs' documentation."""

UNITS = ["IdentifiedPlant", "ReferencePath", "LateralPid"]

WIRES = [
    ("LateralPid", "steering_angle", "IdentifiedPlant", "steering_angle"),
    ("IdentifiedPlant", "x", "ReferencePath", "x"),
    ("IdentifiedPlant", "y", "ReferencePath", "y"),
    ("IdentifiedPlant", "yaw", "ReferencePath", "yaw"),
    ("ReferencePath", "yaw_reference", "LateralPid", "yaw_reference"),
    ("ReferencePath", "steering_feedforward", "LateralPid", "steering_feedforward"),
    ("IdentifiedPlant", "yaw", "LateralPid", "yaw"),
]
