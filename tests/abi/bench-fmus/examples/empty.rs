//! The library of [`bench_fmus::Empty`].
fmi2_export::export!(bench_fmus::Empty);
