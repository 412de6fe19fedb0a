//! Kinds of findings.

use super::program::Program;

/// A kind of finding: one row of the guide.
#[derive(Debug)]
pub struct Kind {
    /// Its name, for programs and for the guide.
    pub code: &'static str,
    /// What is the matter, in a few words.
    pub title: &'static str,
    /// Which programs it breaks, and how; none where it is only worth knowing.
    pub harms: &'static [Harm],
    /// What to do.
    pub remedy: &'static str,
    /// Whether a corrected copy is without it.
    pub mends: Mends,
}

/// What a finding does to some programs.
#[derive(Debug)]
pub struct Harm {
    /// Those that it does it to.
    pub programs: &'static [Program],
    /// How badly.
    pub how: How,
    /// What happens.
    pub text: &'static str,
}

/// How badly a program is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum How {
    /// It answers rightly, within a limit worth knowing.
    Limited,
    /// It says that it cannot, or ends.
    Refuses,
    /// It answers wrongly without a word.
    Wrong,
}

impl How {
    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Limited => "limited",
            Self::Refuses => "refuses",
            Self::Wrong => "wrong",
        }
    }
}

/// When a kind of finding is mended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mends {
    /// In every corrected copy, and how.
    Always(&'static str),
    /// In a copy for a program that it breaks: something is left out, made up or averaged.
    For,
    /// Where it is asked for by its code, and how: whoever made the file knows whether it is a fault.
    Asked(&'static str),
    /// Never: it is not known what the file should say.
    Never,
}

impl Mends {
    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Always(_) => "always",
            Self::For => "for",
            Self::Asked(_) => "asked",
            Self::Never => "never",
        }
    }
}

impl Kind {
    /// What it does to a program.
    pub fn harm(&self, program: Program) -> Option<&'static Harm> {
        self.harms.iter().find(|harm| harm.programs.contains(&program))
    }

    /// Whether a program refuses the file or answers wrongly for it.
    pub fn breaks(&self, program: Program) -> bool {
        self.harm(program).is_some_and(|harm| harm.how > How::Limited)
    }

    /// Whether it matters to whoever uses that program; without one, whether it breaks one or concerns all.
    pub fn matters(&self, program: Option<Program>) -> bool {
        match program {
            Some(program) => self.harms.is_empty() || self.harm(program).is_some(),
            None => {
                let any = |harm: &Harm| {
                    harm.how > How::Limited || harm.programs.len() == Program::ALL.len()
                };
                self.harms.is_empty() || self.harms.iter().any(any)
            }
        }
    }
}
