//! Jobs and their folders, in one test program: building many takes longer than running them.

mod checkpoints;
mod matrix;
mod settings;
