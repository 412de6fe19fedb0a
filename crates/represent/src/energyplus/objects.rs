//! EnergyPlus's objects as IDF and as epJSON.

use std::io::Write;

use bsdfkit::matrix::KlemsBasis;
use bsdfkit::{Error, Result};
use serde_json::{Map, Value, json};

use super::layer::Layer;
use super::system::System;

/// The two forms of EnergyPlus's input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `.idf`.
    Idf,
    /// `.epJSON`.
    EpJson,
}

/// An object: its class, its name, and its fields in the order of an IDF.
#[derive(Clone, Debug)]
pub struct Object {
    /// As `Construction:ComplexFenestrationState`.
    pub class: &'static str,
    /// Unique within the class.
    pub name: String,
    /// (name in epJSON, value); null is left empty.
    pub fields: Vec<(String, Value)>,
    /// The values of a matrix, row by row.
    matrix: Option<Vec<f64>>,
}

impl Object {
    fn new(class: &'static str, name: String, fields: Vec<(&str, Value)>) -> Self {
        let fields = fields.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        Self { class, name, fields, matrix: None }
    }

    fn matrix(name: String, rows: usize, values: Vec<f64>) -> Self {
        let columns = values.len() / rows;
        let fields = vec![("number_of_rows", json!(rows)), ("number_of_columns", json!(columns))];
        Self { matrix: Some(values), ..Self::new("Matrix:TwoDimension", name, fields) }
    }
}

/// Six digits: those of the measurement are fewer.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// Every object that the construction names, and itself.
pub(super) fn all(
    name: &str,
    layers: &[Layer],
    solar: &System,
    visible: &System,
    gap: f64,
    basis: &KlemsBasis,
) -> Vec<Object> {
    let n = basis.directions();
    let rings = (0..basis.rings().len())
        .flat_map(|r| [basis.ring_centre_degrees(r), basis.rings()[r].patches as f64]);
    let called = |what: &str| format!("{name} {what}");
    let mut objects = vec![
        Object::matrix(called("basis"), basis.rings().len(), rings.collect()),
        Object::matrix(called("Tf solar"), n, solar.transmission.clone()),
        Object::matrix(called("Rb solar"), n, solar.reflection_back.clone()),
        Object::matrix(called("Tf visible"), n, visible.transmission.clone()),
        Object::matrix(called("Rb visible"), n, visible.reflection_back.clone()),
    ];
    let mut construction = vec![
        ("basis_type".to_owned(), json!("LBNLWINDOW")),
        ("basis_symmetry_type".to_owned(), json!("None")),
        ("window_thermal_model".to_owned(), json!(called("thermal"))),
        ("basis_matrix_name".to_owned(), json!(called("basis"))),
        (
            "solar_optical_complex_front_transmittance_matrix_name".to_owned(),
            json!(called("Tf solar")),
        ),
        (
            "solar_optical_complex_back_reflectance_matrix_name".to_owned(),
            json!(called("Rb solar")),
        ),
        (
            "visible_optical_complex_front_transmittance_matrix_name".to_owned(),
            json!(called("Tf visible")),
        ),
        // Named back transmittance, and used as back reflectance.
        (
            "visible_optical_complex_back_transmittance_matrix_name".to_owned(),
            json!(called("Rb visible")),
        ),
    ];
    for (k, layer) in layers.iter().enumerate() {
        let number = k + 1;
        let (absorbed, from_inside) =
            (called(&format!("Af {number}")), called(&format!("Ab {number}")));
        objects.push(Object::matrix(absorbed.clone(), 1, solar.absorbed_front[k].clone()));
        objects.push(Object::matrix(from_inside.clone(), 1, solar.absorbed_back[k].clone()));
        let pane = called(&format!("layer {number}"));
        objects.push(glazing(pane.clone(), layer));
        let prefix = match k {
            0 => "outside_layer".to_owned(),
            _ => format!("layer_{number}"),
        };
        if k > 0 {
            construction.extend([
                (format!("gap_{k}_name"), json!(called(&format!("gap {k}")))),
                (format!("cfs_gap_{k}_directional_front_absorptance_matrix_name"), Value::Null),
                (format!("cfs_gap_{k}_directional_back_absorptance_matrix_name"), Value::Null),
            ]);
        }
        construction.extend([
            (format!("{prefix}_name"), json!(pane)),
            (format!("{prefix}_directional_front_absorptance_matrix_name"), json!(absorbed)),
            (format!("{prefix}_directional_back_absorptance_matrix_name"), json!(from_inside)),
        ]);
    }
    for k in 1..layers.len() {
        let gas = called(&format!("air {k}"));
        objects.push(Object::new(
            "WindowMaterial:Gas",
            gas.clone(),
            vec![("gas_type", json!("Air")), ("thickness", json!(gap))],
        ));
        objects.push(Object::new(
            "WindowMaterial:Gap",
            called(&format!("gap {k}")),
            vec![("thickness", json!(gap)), ("gas_or_gas_mixture_", json!(gas))],
        ));
    }
    objects.push(Object::new(
        "WindowThermalModel:Params",
        called("thermal"),
        vec![("standard", json!("ISO15099")), ("thermal_model", json!("ISO15099"))],
    ));
    objects.push(Object {
        class: "Construction:ComplexFenestrationState",
        name: name.to_owned(),
        fields: construction,
        matrix: None,
    });
    objects
}

fn glazing(name: String, layer: &Layer) -> Object {
    let [front, back] = layer.emissivities;
    let fields = vec![
        ("optical_data_type", json!("BSDF")),
        ("window_glass_spectral_data_set_name", Value::Null),
        ("thickness", json!(layer.thickness)),
        ("solar_transmittance_at_normal_incidence", Value::Null),
        ("front_side_solar_reflectance_at_normal_incidence", Value::Null),
        ("back_side_solar_reflectance_at_normal_incidence", Value::Null),
        ("visible_transmittance_at_normal_incidence", Value::Null),
        ("front_side_visible_reflectance_at_normal_incidence", Value::Null),
        ("back_side_visible_reflectance_at_normal_incidence", Value::Null),
        ("infrared_transmittance_at_normal_incidence", json!(layer.infrared_transmittance)),
        ("front_side_infrared_hemispherical_emissivity", json!(front)),
        ("back_side_infrared_hemispherical_emissivity", json!(back)),
        ("conductivity", json!(layer.conductivity)),
    ];
    Object::new("WindowMaterial:Glazing", name, fields)
}

/// Values in a row of an IDF's text.
const IN_A_ROW: usize = 10;

/// Writes objects.
///
/// Errors: io.
pub(super) fn write(out: &mut impl Write, objects: &[Object], form: Form) -> Result<()> {
    let io = |e: std::io::Error| Error::io("writing", &e);
    let text = match form {
        Form::Idf => objects.iter().map(idf).collect::<Vec<_>>().join("\n"),
        Form::EpJson => format!("{:#}\n", ep_json(objects)),
    };
    out.write_all(text.as_bytes()).map_err(io)
}

fn idf(object: &Object) -> String {
    let written = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let mut fields = vec![object.name.clone()];
    fields.extend(object.fields.iter().map(|(_, value)| written(value)));
    let mut text = format!("{},\n", object.class);
    if let Some(values) = &object.matrix {
        text += &format!("  {},\n", fields.join(", "));
        let rows: Vec<String> = values
            .chunks(IN_A_ROW)
            .map(|row| row.iter().map(|v| rounded(*v).to_string()).collect::<Vec<_>>().join(", "))
            .collect();
        return text + "  " + &rows.join(",\n  ") + ";\n";
    }
    text + "  " + &fields.join(",\n  ") + ";\n"
}

fn ep_json(objects: &[Object]) -> Value {
    let mut file = Map::new();
    for object in objects {
        let filled = object.fields.iter().filter(|(_, value)| !value.is_null());
        let mut fields: Map<String, Value> =
            filled.map(|(key, value)| (key.clone(), value.clone())).collect();
        if let Some(values) = &object.matrix {
            let values: Vec<Value> =
                values.iter().map(|v| json!({ "value": rounded(*v) })).collect();
            fields.insert("values".to_owned(), Value::Array(values));
        }
        let class = file.entry(object.class).or_insert_with(|| json!({}));
        class[&object.name] = Value::Object(fields);
    }
    Value::Object(file)
}
