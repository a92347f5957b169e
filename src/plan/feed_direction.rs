//! The way the tool travels.

/// The way the tool travels.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum FeedDirection {
    /// From the tailstock to the chuck, as usual.
    #[default]
    TowardsChuck,
    /// From the chuck to the tailstock.
    TowardsTailstock,
}
