//! The library of [`steerwright_bench_fmus::Linear`].
fmi2_export::export!(steerwright_bench_fmus::Linear);
