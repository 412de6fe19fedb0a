//! A lit object: what the material looks like.

/// Rows of a picture.
pub(crate) fn rows(
    _bsdf: &bsdfkit::Bsdf,
    _shape: &str,
    _light: bsdfkit::DVec3,
    _selection: &crate::Selection,
    _size: usize,
    _rows: std::ops::Range<usize>,
) -> Vec<f32> {
    Vec::new()
}
