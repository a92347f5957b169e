//! Worn noses and what they leave: closed forms, envelopes by brute force, paths and programs.

mod compensation;
mod envelope;
mod parts;
mod profile;
mod program;
