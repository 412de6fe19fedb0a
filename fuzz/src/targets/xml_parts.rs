//! XML put together of parts that fit, or nearly.

use std::fmt::Write;

use arbitrary::{Arbitrary, Result, Unstructured};

use super::xml::xml;

const STRUCTURES: [&str; 6] =
    ["TensorTree3", "TensorTree4", "Columns", "Rows", " columns ", "TensorTree5"];
const DIRECTIONS: [&str; 5] = [
    "Transmission Front",
    "Transmission Back",
    "Reflection Front",
    "Reflection Back",
    "Scattering Sideways",
];
const NAMES: [&str; 5] =
    ["LBNL/Klems Quarter", "LBNL/Klems Half", "LBNL/Klems Full", "mine", "nobody's"];
const BANDS: [&str; 8] =
    ["Visible", "Solar", "NIR", "CIE-X", "CIE-Z", "CIE-u", "CIE-v", " Visible "];
const WORDS: [&str; 12] =
    ["0", "-0", "1", "0.25", "1e38", "3.5e38", "1e-45", "1e400", "nan", "-1", "1.e", "0x1"];

/// Bytes as choices among parts of a file.
pub fn xml_parts(bytes: &[u8]) {
    let mut choices = Unstructured::new(bytes);
    if let Ok(text) = file(&mut choices) {
        xml(text.as_bytes());
    }
}

fn file(choices: &mut Unstructured<'_>) -> Result<String> {
    let structure = *choices.choose(&STRUCTURES)?;
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<WindowElement><FileType>BSDF</FileType><Optical><Layer><Material><Name>{}</Name>",
        choices.choose(&["a", "", "&lt;&#65;", "&unknown;", "é"])?
    );
    let unit = choices.choose(&["meter", "millimeter", "", "mile"])?;
    let word = choices.choose(&WORDS)?;
    write!(text, "<Thickness unit=\"{unit}\">{word}</Thickness></Material>").expect("a string");
    write!(text, "<DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure>")
        .expect("a string");
    let mut directions = None;
    for _ in 0..choices.int_in_range(0..=2)? {
        basis(&mut text, &mut directions, choices)?;
    }
    text += "</DataDefinition>";
    for _ in 0..choices.int_in_range(1..=3)? {
        block(&mut text, structure, directions, choices)?;
    }
    text += "</Layer></Optical></WindowElement>";
    Ok(text)
}

/// An angle basis; `directions` becomes how many it has.
fn basis(
    text: &mut String,
    directions: &mut Option<usize>,
    choices: &mut Unstructured<'_>,
) -> Result<()> {
    let name = choices.choose(&NAMES)?;
    write!(text, "<AngleBasis><AngleBasisName>{name}</AngleBasisName>").expect("a string");
    let rings = choices.int_in_range(1..=4_u32)?;
    let mut total = 0;
    for ring in 0..rings {
        let lower = 90.0 * f64::from(ring) / f64::from(rings);
        let mut upper = 90.0 * f64::from(ring + 1) / f64::from(rings);
        if choices.ratio(1, 16)? {
            upper = f64::from(choices.int_in_range(-10..=200)?);
        }
        let azimuths = match choices.ratio(1, 16)? {
            true => *choices.choose(&[0, -1, 4097, 1 << 31])?,
            false => choices.int_in_range(1..=4_i64)?,
        };
        total += azimuths.clamp(0, 1 << 16) as usize;
        write!(
            text,
            "<AngleBasisBlock><Theta>{lower}</Theta><nPhis>{azimuths}</nPhis><ThetaBounds>\
             <LowerTheta>{lower}</LowerTheta><UpperTheta>{upper}</UpperTheta></ThetaBounds></AngleBasisBlock>"
        )
        .expect("a string");
    }
    *directions = Some(total);
    *text += "</AngleBasis>";
    Ok(())
}

fn block(
    text: &mut String,
    structure: &str,
    directions: Option<usize>,
    choices: &mut Unstructured<'_>,
) -> Result<()> {
    let band = choices.choose(&BANDS)?;
    let direction = choices.choose(&DIRECTIONS)?;
    let angles = if structure.starts_with("Tensor") {
        let name = choices.choose(&["LBNL/Shirley-Chiu", "LBNL/Klems Full"])?;
        format!("<AngleBasis>{name}</AngleBasis>")
    } else {
        let [columns, rows] = [choices.choose(&NAMES)?, choices.choose(&NAMES)?];
        format!(
            "<ColumnAngleBasis>{columns}</ColumnAngleBasis><RowAngleBasis>{rows}</RowAngleBasis>"
        )
    };
    writeln!(
        text,
        "<WavelengthData><Wavelength>{band}</Wavelength><WavelengthDataBlock>\
         <WavelengthDataDirection>{direction}</WavelengthDataDirection>{angles}<ScatteringData>"
    )
    .expect("a string");
    if structure.starts_with("Tensor") {
        let children = if structure == "TensorTree4" { 16 } else { 8 };
        tree(text, children, 3, choices)?;
    } else {
        let directions = directions.unwrap_or(41);
        let count = (directions * directions).min(1 << 12);
        let wrong = choices.ratio(1, 8)?;
        for _ in 0..count + usize::from(wrong) {
            let word = if choices.ratio(1, 32)? { choices.choose(&WORDS)? } else { "0.1" };
            *text += word;
            *text += choices.choose(&[" ", ", ", "\n"])?;
        }
    }
    *text += "</ScatteringData></WavelengthDataBlock></WavelengthData>";
    Ok(())
}

/// A node: a leaf, a branch, a grid of leaves, or a branch that lacks some.
fn tree(
    text: &mut String,
    children: u32,
    depth: u32,
    choices: &mut Unstructured<'_>,
) -> Result<()> {
    *text += "{ ";
    let open = depth > 0 && bool::arbitrary(choices)?;
    if open {
        let wrong = choices.ratio(1, 16)?;
        for _ in 0..children - u32::from(wrong) {
            tree(text, children, depth - 1, choices)?;
        }
    } else {
        let values = match choices.int_in_range(0..=7)? {
            0 => children,
            1 => children * children,
            2 => choices.int_in_range(0..=40)?,
            _ => 1,
        };
        for _ in 0..values {
            *text += choices.choose(&WORDS[..5])?;
            *text += " ";
        }
    }
    *text += if choices.ratio(1, 64)? { "\n" } else { "}\n" };
    Ok(())
}
