//! Incidences into the fundamental domain of their symmetry.

use bsdfkit::DVec3;

use super::{Image, Incidence, MERGE_DEGREES, Measurement, Symmetry};

/// Moves every incidence into the symmetry's fundamental domain, merges those that meet there, and completes those
/// that were scanned on one side of a mirror plane only.
pub(super) fn fold(component: &mut Measurement) {
    let symmetry = component.symmetry;
    let near = MERGE_DEGREES.to_radians().cos();
    let mut folded: Vec<Incidence> = Vec::new();
    let (mut merged, mut completed) = (0, 0);
    for mut incidence in std::mem::take(&mut component.incidences) {
        let (wi, image) = symmetry.fold(incidence.wi);
        incidence.wi = wi;
        if image != Image::IDENTITY {
            incidence.wo.change(|w| image.apply(w));
        }
        match folded.iter_mut().find(|f| f.wi.dot(wi) >= near) {
            Some(same) => {
                same.wo.append(&mut incidence.wo);
                same.values.append(&mut incidence.values);
                same.files.append(&mut incidence.files);
                merged += 1;
            }
            None => folded.push(incidence),
        }
    }
    for incidence in &mut folded {
        completed += usize::from(complete(incidence, symmetry));
    }
    if merged > 0 {
        component.notes.push(format!("{merged} incidences merged with their {symmetry} images"));
    }
    if completed > 0 {
        component.notes.push(format!(
            "{completed} incidences scanned on one side of a mirror plane only: the other side is their image"
        ));
    }
    component.incidences = folded;
}

/// Mirrors the points of an incidence that lies in a mirror plane and was scanned on one side of it; whether it was.
///
/// An isotropic specimen mirrors in every plane of incidence, as far as it has no handedness.
fn complete(incidence: &mut Incidence, symmetry: Symmetry) -> bool {
    let all = symmetry.images();
    let mirror_y = symmetry == Symmetry::Isotropic || all.contains(&Image::MIRROR_Y);
    let mirror_x = all.contains(&Image::MIRROR_X);
    let mut done = false;
    for (holds, image, axis) in
        [(mirror_x, Image::MIRROR_X, DVec3::X), (mirror_y, Image::MIRROR_Y, DVec3::Y)]
    {
        if holds && incidence.wi.dot(axis).abs() < MERGE_DEGREES.to_radians() {
            done |= mirror(incidence, image, axis);
        }
    }
    done
}

/// Adds the images of all points, where these lie on one side of the plane across `axis`.
fn mirror(incidence: &mut Incidence, image: Image, axis: DVec3) -> bool {
    let plane = MERGE_DEGREES.to_radians();
    let beside = |sign: f64| incidence.wo.iter().any(|w| sign * w.dot(axis) > plane);
    if beside(1.0) == beside(-1.0) {
        return false;
    }
    let channels = incidence.channels();
    for index in 0..incidence.wo.len() {
        let w = incidence.wo.at(index);
        if w.dot(axis).abs() > plane {
            incidence.wo.push(image.apply(w));
            incidence.values.extend_from_within(index * channels..(index + 1) * channels);
        }
    }
    true
}
