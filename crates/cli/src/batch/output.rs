//! The files that a material becomes: forms and programs, and what each file is called.

use std::fmt;
use std::str::FromStr;

use bsdfkit::{Error, Result};
use bsdfkit_fit::deliver::{Consumer, Kind};

/// What one file of a material is to be: a form, a program that reads it, or both as `window:klems-full`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Output {
    consumer: Option<Consumer>,
    kind: Option<Kind>,
}

impl Output {
    /// What is made of a material of which nothing else is said.
    pub(crate) const USUAL: [Self; 2] = [
        Self { consumer: None, kind: Some(Kind::Interpolant) },
        Self { consumer: None, kind: Some(Kind::TensorTree) },
    ];

    /// Its file's name: what is between the dots does not count in a catalogue, so all are one material there.
    pub(crate) fn file(self, name: &str) -> String {
        match (self.consumer, self.kind) {
            (None, Some(Kind::RglRgb)) => format!("{name}_rgb.bsdf"),
            (None, Some(Kind::RglSpectral)) => format!("{name}_spec.bsdf"),
            (None, Some(Kind::Interpolant)) => format!("{name}.safetensors"),
            (None, Some(Kind::Render)) => format!("{name}.render.safetensors"),
            (None, None | Some(Kind::TensorTree)) => format!("{name}.xml"),
            (None, Some(kind)) => format!("{name}.{}.xml", kind.name()),
            (Some(consumer), None) => format!("{name}.{}.xml", consumer.name()),
            (Some(consumer), Some(kind)) => {
                format!("{name}.{}.{}.xml", consumer.name(), kind.name())
            }
        }
    }

    /// What stands before its `-o` on the command line of `bsdf fit`.
    pub(crate) fn marks(self) -> Vec<String> {
        let consumer = self.consumer.map(|c| ["--for".to_owned(), c.name().to_owned()]);
        let kind = self.kind.map(|k| ["--to".to_owned(), k.name().to_owned()]);
        consumer.into_iter().chain(kind).flatten().collect()
    }
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = [self.consumer.map(Consumer::name), self.kind.map(Kind::name)];
        f.write_str(&names.into_iter().flatten().collect::<Vec<_>>().join(":"))
    }
}

impl FromStr for Output {
    type Err = Error;

    /// Errors: argument, for a text that names neither a form nor a program, and for a form that the program does not read.
    fn from_str(text: &str) -> Result<Self> {
        let wrong = || {
            let kinds = Kind::ALL.map(Kind::name).join(", ");
            let consumers = Consumer::ALL.map(Consumer::name).join(", ");
            Error::argument(format!(
                "expected a form ({kinds}), a program ({consumers}) or PROGRAM:FORM, found {text:?}"
            ))
        };
        let output = match text.split_once(':') {
            Some((consumer, kind)) => Self {
                consumer: Some(consumer.parse().map_err(|_| wrong())?),
                kind: Some(kind.parse().map_err(|_| wrong())?),
            },
            None => match text.parse() {
                Ok(kind) => Self { consumer: None, kind: Some(kind) },
                Err(_) => Self { consumer: Some(text.parse().map_err(|_| wrong())?), kind: None },
            },
        };
        if let Some(consumer) = output.consumer {
            consumer.kind(output.kind)?;
        }
        Ok(output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_output_has_a_file_of_its_own() {
        let kinds = Kind::ALL.map(|k| k.name().to_owned());
        let more = ["window", "radiance", "energyplus", "energyplus:klems-half"].map(str::to_owned);
        let mut names = Vec::new();
        for text in kinds.into_iter().chain(more) {
            let output: Output = text.parse().unwrap();
            assert_eq!(output.to_string(), text);
            names.push(output.file("a"));
        }
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "{names:?}");
    }

    #[test]
    fn what_is_no_output_is_told() {
        for (text, words) in [
            ("sphere", "expected a form (tensor-tree"),
            ("window:sphere", "expected a form"),
            ("window:tensor-tree", "window reads klems-full"),
            ("", "expected a form"),
        ] {
            let error = text.parse::<Output>().unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
