//! The library of [`bench_fmus::Linear`].
fmi2_export::export!(bench_fmus::Linear);
