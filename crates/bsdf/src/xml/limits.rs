//! What a reader of untrusted files refuses to exceed.

/// Limits of the XML reader; [`Limits::default`] reads every file seen in the wild and keeps
/// memory below about four times the file's size.
///
/// All but `faults` are errors of class [`Limit`](crate::ErrorClass::Limit) when exceeded.
/// The numbers are guesses a decade above the largest real file; doubling one costs memory only.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Size of the file.
    pub file_bytes: u64,
    /// XML elements in the file.
    pub elements: usize,
    /// Nesting of XML elements.
    pub element_depth: usize,
    /// Numbers in all data blocks together.
    pub values: usize,
    /// Halvings of a tensor tree along each axis; a leaf is then 2^−depth wide.
    pub tree_depth: u32,
    /// Angle bases in a file.
    pub bases: usize,
    /// Spectral bands beside the visible one.
    pub bands: usize,
    /// Rings of an angle basis.
    pub rings: usize,
    /// Azimuth patches of a ring.
    pub azimuths: usize,
    /// Bytes of a name, a unit or any other short text (geometry is only limited by the file).
    pub text_bytes: usize,
    /// Faults listed in one error message; the rest are counted.
    pub faults: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 1 << 30,
            elements: 1 << 20,
            element_depth: 64,
            values: 1 << 28,
            tree_depth: 16,
            bases: 64,
            bands: 1024,
            rings: 1024,
            azimuths: 4096,
            text_bytes: 1 << 16,
            faults: 20,
        }
    }
}
