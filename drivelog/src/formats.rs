//! The formats of logs, as help and messages list them.

/// The formats of logs, as texts for users list them.
pub const LOG_FORMATS: &str = "CSV, MDF, MCAP, Parquet, Arrow (Feather), or a CAN bus (candump, ASC, TRC, BUSMASTER, Kvaser, or CSV of cabana, SavvyCAN, python-can, Vehicle Spy, CANedge or CL2000)";
