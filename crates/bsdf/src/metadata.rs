//! What a file says about the specimen, apart from numbers to query.

use serde::{Deserialize, Serialize};

/// Description of a material.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Metadata {
    /// Name of the material.
    pub name: String,
    /// Who makes it.
    pub manufacturer: String,
    /// Width in metres; 0 when not given.
    pub width: f64,
    /// Height in metres; 0 when not given.
    pub height: f64,
    /// Thickness in metres; 0 when not given.
    pub thickness: f64,
    /// Geometry of the device as MGF text, in metres.
    pub geometry: Option<String>,
    /// Comments, in the order of the file.
    pub comments: Vec<String>,
    /// Every other (key, value), in the order of the file: `DeviceType`, `TIR`, ….
    pub properties: Vec<(String, String)>,
    /// Elements of an XML file that nothing here interprets, as they were written (absorptances,
    /// slat geometry, …), by the path of their parent below the root: `Optical/Layer`. Whole blocks
    /// of data stand under `Optical/Layer/WavelengthData`, see [`Metadata::bound`].
    pub unread: Vec<(String, String)>,
}

impl Metadata {
    /// The value of a property, by its exact key.
    pub fn property(&self, key: &str) -> Option<&str> {
        self.properties.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }
}
