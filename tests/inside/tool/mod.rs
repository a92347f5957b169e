//! Worn noses and what they leave: closed forms, envelopes by brute force, paths and programs.

mod compensation;
mod cut;
mod envelope;
mod parts;
mod profile;
mod program;
mod study;
mod worn_part;
