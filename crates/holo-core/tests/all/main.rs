//! The library through its public interface, in one test program: building many takes longer than running them.

mod geometry;
mod layouts;
mod metrics;
mod plane_sweep;
mod refocus;
