//! A value of JSON and where it stands.

use bsdfkit::{Error, Result};
use serde_json::Value;

/// What an error tells of a value that is none of those expected: characters of it.
const SHOWN: usize = 60;

/// A value and its place: `data[0].dataPoints[3].results`.
#[derive(Clone, Debug)]
pub(super) struct Place<'v> {
    path: String,
    value: &'v Value,
}

impl<'v> Place<'v> {
    pub(super) fn root(value: &'v Value) -> Self {
        Self { path: String::new(), value }
    }

    /// The error where something else was expected.
    pub(super) fn expected(&self, what: &str) -> Error {
        let text = self.value.to_string();
        let mut found: String = text.chars().take(SHOWN).collect();
        if found.len() < text.len() {
            found.push('…');
        }
        let place = if self.path.is_empty() { "the file" } else { &self.path };
        Error::format(format!("BED-JSON: {place}: expected {what}, found {found}"))
    }

    /// A field that may be absent; `null` counts as absent.
    pub(super) fn get(&self, name: &str) -> Option<Self> {
        let value = self.value.get(name).filter(|v| !v.is_null())?;
        let dot = if self.path.is_empty() { "" } else { "." };
        Some(Self { path: format!("{}{dot}{name}", self.path), value })
    }

    /// A field that must be there.
    ///
    /// Errors: format.
    pub(super) fn field(&self, name: &str) -> Result<Self> {
        self.get(name).ok_or_else(|| self.expected(&format!("an object with {name:?}")))
    }

    /// The members of an array that has some.
    ///
    /// Errors: format.
    pub(super) fn items(&self) -> Result<impl Iterator<Item = Self> + use<'v>> {
        let items = self.value.as_array().filter(|items| !items.is_empty());
        let items = items.ok_or_else(|| self.expected("an array that is not empty"))?;
        let path = self.path.clone();
        let place = move |(k, value)| Self { path: format!("{path}[{k}]"), value };
        Ok(items.iter().enumerate().map(place))
    }

    pub(super) fn text(&self) -> Option<&'v str> {
        self.value.as_str()
    }

    /// A number from `low` to `high`, or one with its uncertainty, which is left out.
    ///
    /// Errors: format.
    pub(super) fn number(&self, low: f64, high: f64) -> Result<f64> {
        let bare = self.get("uncertainValue");
        let number = bare.as_ref().unwrap_or(self).value.as_f64();
        number
            .filter(|n| (low..=high).contains(n))
            .ok_or_else(|| self.expected(&format!("a number from {low} to {high}")))
    }
}
