//! Worn noses and what they leave: closed forms, envelopes by brute force, paths and programs.

mod bore;
mod compensation;
mod cut;
mod envelope;
mod parts;
mod precondition;
mod profile;
mod program;
mod study;
mod tangency;
mod worn_part;
