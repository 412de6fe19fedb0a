//! Everything wrong with a file, collected before one error is made of it.

use std::fmt;

use crate::{Error, ErrorClass};

/// Something questionable that did not prevent reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// What kind of thing it is; [`doctor`](super::doctor) says of each which program it breaks.
    pub code: &'static str,
    /// Line and path of the element.
    pub place: String,
    /// What is questionable and what was done about it.
    pub text: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.text)
    }
}

/// One reason not to accept a file.
#[derive(Debug)]
pub(crate) struct Fault {
    class: ErrorClass,
    pub(super) place: String,
    pub(super) text: String,
}

impl Fault {
    pub(crate) fn format(place: String, text: impl Into<String>) -> Self {
        Self { class: ErrorClass::Format, place, text: text.into() }
    }

    pub(crate) fn limit(place: String, text: impl Into<String>) -> Self {
        Self { class: ErrorClass::Limit, place, text: text.into() }
    }
}

/// Faults and warnings of one file, the first `most` of each.
#[derive(Debug)]
pub(crate) struct Report {
    most: usize,
    faults: Vec<Fault>,
    faults_left_out: usize,
    /// `None` when nobody will look at them.
    warnings: Option<Vec<Warning>>,
}

impl Report {
    pub(crate) fn new(most: usize) -> Self {
        Self {
            most: most.max(1),
            faults: Vec::new(),
            faults_left_out: 0,
            warnings: Some(Vec::new()),
        }
    }

    /// Of faults only.
    pub(crate) fn without_warnings(most: usize) -> Self {
        Self { warnings: None, ..Self::new(most) }
    }

    /// Whether warnings are kept: those that are costly to find need not be looked for otherwise.
    pub(crate) fn wants_warnings(&self) -> bool {
        self.warnings.is_some()
    }

    pub(crate) fn fault(&mut self, fault: Fault) {
        if self.faults.len() < self.most {
            self.faults.push(fault);
        } else {
            self.faults_left_out += 1;
        }
    }

    pub(crate) fn warn(&mut self, code: &'static str, place: String, text: impl Into<String>) {
        if let Some(warnings) = &mut self.warnings
            && warnings.len() < self.most
        {
            warnings.push(Warning { code, place, text: text.into() });
        }
    }

    pub(crate) fn has_faults(&self) -> bool {
        !self.faults.is_empty()
    }

    /// The warnings, or one error that lists all faults; of class limit only if all of them are.
    pub(crate) fn finish(self) -> Result<Vec<Warning>, Error> {
        let Some(first) = self.faults.first() else { return Ok(self.warnings.unwrap_or_default()) };
        let line = |fault: &Fault| match fault.place.as_str() {
            "" => fault.text.clone(),
            place => format!("{place}: {}", fault.text),
        };
        let mut message = line(first);
        let count = self.faults.len() + self.faults_left_out;
        if count > 1 {
            message = format!("{count} faults");
            for fault in &self.faults {
                message += &format!("\n  {}", line(fault));
            }
            if self.faults_left_out > 0 {
                message += &format!("\n  and {} more", self.faults_left_out);
            }
        }
        Err(if self.faults.iter().all(|f| f.class == ErrorClass::Limit) {
            Error::limit(message)
        } else {
            Error::format(message)
        })
    }
}
