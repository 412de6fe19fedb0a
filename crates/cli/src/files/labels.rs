//! What the specimen is called.

use bsdfkit::xml::set_property;
use bsdfkit::{Error, Metadata, Result};
use clap::Args;

/// What the specimen is called, for outputs in XML.
#[derive(Args, Clone, Debug)]
pub(crate) struct Labels {
    /// Name of the material [default: as the input names it]
    #[arg(long)]
    name: Option<String>,
    /// Who makes it
    #[arg(long)]
    manufacturer: Option<String>,
    /// Thickness in metres
    #[arg(long, value_name = "METRES")]
    thickness: Option<f64>,
    /// Width in metres: of the pane that Radiance's pkgBSDF makes
    #[arg(long, value_name = "METRES")]
    width: Option<f64>,
    /// Height in metres, likewise
    #[arg(long, value_name = "METRES")]
    height: Option<f64>,
    /// Any other field of the material, as ThermalConductivity=0.2 or TIR=0; may be repeated
    #[arg(long, value_name = "FIELD=VALUE")]
    property: Vec<String>,
}

impl Labels {
    /// `metadata` with what was given.
    ///
    /// Errors: argument, for a length that is none, and for a property that is none.
    pub(crate) fn over(&self, mut metadata: Metadata) -> Result<Metadata> {
        if let Some(name) = &self.name {
            metadata.name.clone_from(name);
        }
        if let Some(manufacturer) = &self.manufacturer {
            metadata.manufacturer.clone_from(manufacturer);
        }
        let lengths = [
            ("thickness", self.thickness, &mut metadata.thickness),
            ("width", self.width, &mut metadata.width),
            ("height", self.height, &mut metadata.height),
        ];
        for (name, given, known) in lengths {
            let Some(length) = given else { continue };
            if !(length.is_finite() && length >= 0.0) {
                return Err(Error::argument(format!(
                    "{name}: expected metres of at least 0, found {length}"
                )));
            }
            *known = length;
        }
        for property in &self.property {
            let Some((key, value)) = property.split_once('=') else {
                return Err(Error::argument(format!(
                    "property: expected FIELD=VALUE, found {property:?}"
                )));
            };
            set_property(&mut metadata, key, value)?;
        }
        Ok(metadata)
    }
}
