//! A file mended for a program: what is a fault for all of them, then what that one lacks.

use bsdfkit::xml::doctor::{self, Finding, Mends, Program};
use bsdfkit::xml::{self, Limits, WriteOptions};
use bsdfkit::{Bsdf, Result};

use super::consumer::Consumer;
use super::order::Order;
use super::subject::Subject;
use bsdfkit_represent::Watch;

/// A corrected copy, and what became of the file.
#[derive(Debug)]
pub struct Mended {
    /// The copy; the file itself, byte by byte, where there was nothing to mend.
    pub bytes: Vec<u8>,
    /// What is no longer there.
    pub changes: Vec<Change>,
    /// What was left out or made up for the program, a sentence each.
    pub said: Vec<String>,
    /// What is found in the copy.
    pub left: Vec<Finding>,
}

/// One thing mended.
#[derive(Debug)]
pub struct Change {
    /// What it was.
    pub finding: Finding,
    /// What was done.
    pub how: String,
}

/// Digits that keep every bit of an f32.
const DIGITS: usize = 9;

impl Consumer {
    /// What a program reads, where it is more than any file in our XML.
    fn of(program: Program) -> Option<Self> {
        match program {
            Program::Window | Program::Frads => Some(Self::Window),
            Program::EnergyPlus => Some(Self::EnergyPlus),
            Program::Radiance | Program::Honeybee | Program::Mitsuba => None,
        }
    }
}

/// Mends a file of our XML ([`doctor::mend`]); for a program also what it refuses: form, bands and sides that it
/// wants, as [`Order::deliver`] makes them. Mending twice changes nothing.
///
/// Errors: as both.
pub fn mend(
    bytes: &[u8],
    program: Option<Program>,
    also: &[&str],
    limits: &Limits,
    watch: &Watch<'_>,
) -> Result<Mended> {
    let doctor::Mended { bytes, changes, left } = doctor::mend(bytes, also, limits)?;
    let change = |(finding, how): (Finding, &str)| Change { finding, how: how.to_owned() };
    let changes = changes.into_iter().map(change).collect();
    let mut mended = Mended { bytes, changes, said: Vec::new(), left };
    if let Some(program) = program {
        mended.fit(program, limits, watch)?;
    }
    Ok(mended)
}

impl Mended {
    /// Makes of the copy what `program` reads.
    fn fit(&mut self, program: Program, limits: &Limits, watch: &Watch<'_>) -> Result<()> {
        let lacks = |f: &&Finding| f.kind.mends == Mends::For && f.kind.harm(program).is_some();
        let Some(consumer) = Consumer::of(program) else { return Ok(()) };
        if !self.left.iter().any(|f| lacks(&f)) {
            return Ok(());
        }
        let (bsdf, _) = xml::from_bytes(&self.bytes, limits)?;
        let (bytes, said) = delivered(&bsdf, consumer, watch)?;
        let left = doctor::examine(&bytes, limits).findings;
        let gone = |f: &&Finding| lacks(f) && !left.iter().any(|l| l.kind.code == f.kind.code);
        let change = |f: &Finding| {
            let how = format!("as {} reads it", program.name());
            Change { finding: f.clone(), how }
        };
        let before = self.changes.len();
        self.changes.extend(self.left.iter().filter(gone).map(change));
        if self.changes.len() > before {
            (self.bytes, self.said, self.left) = (bytes, said, left);
        }
        Ok(())
    }
}

fn delivered(bsdf: &Bsdf, consumer: Consumer, watch: &Watch<'_>) -> Result<(Vec<u8>, Vec<String>)> {
    let subject = Subject::Stored(bsdf);
    let order = Order { consumer: Some(consumer), ..Order::new(consumer.kind_of(subject)) };
    let delivered = order.deliver(subject, bsdf.metadata().clone(), watch)?;
    let mut bytes = Vec::new();
    let options = WriteOptions { digits: DIGITS, ..WriteOptions::default() };
    xml::write_to(&delivered.bsdf, &mut bytes, &options)?;
    Ok((bytes, delivered.said))
}
