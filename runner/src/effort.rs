//! How much a study computes, as the command line says it.

use clap::Args;

/// `--quick` and `--smoke`.
#[derive(Args, Clone, Copy)]
pub struct Flags {
    /// Fewer points and fewer runs in each mean: minutes on two cores.
    #[arg(long, conflicts_with = "smoke")]
    quick: bool,
    /// Small sheets and two runs in each mean, a minute at most: a check that everything works, not a result.
    #[arg(long)]
    smoke: bool,
}

impl Flags {
    /// What they ask for.
    pub fn effort(self) -> Effort {
        match (self.smoke, self.quick) {
            (true, _) => Effort::Smoke,
            (_, true) => Effort::Quick,
            _ => Effort::Full,
        }
    }
}

/// How much is computed.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub enum Effort {
    /// A minute at most, and no physics to be read off.
    Smoke,
    /// Minutes.
    Quick,
    /// What the documents rest on.
    Full,
}
