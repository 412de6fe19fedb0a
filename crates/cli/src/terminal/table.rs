//! Aligned columns of text.

use std::io::{self, Write};

/// A table with a header; words to the left, numbers to the right.
#[derive(Debug)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table with these column heads.
    pub(crate) fn new<const N: usize>(heads: [&str; N]) -> Self {
        Self { rows: vec![heads.map(str::to_owned).to_vec()] }
    }

    /// Appends a row.
    pub(crate) fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.into());
    }

    /// Prints it, every line indented by `indent` spaces.
    pub(crate) fn print(&self, out: &mut impl Write, indent: usize) -> io::Result<()> {
        let columns = self.rows[0].len();
        let body = &self.rows[1..];
        let width = |c: usize| self.rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let number = |c: usize| {
            body.iter().any(|r| !r[c].is_empty())
                && body
                    .iter()
                    .all(|r| r[c].starts_with(|x: char| x.is_ascii_digit() || "-.~>".contains(x)))
        };
        let right: Vec<bool> = (0..columns).map(number).collect();
        for row in &self.rows {
            let mut line = " ".repeat(indent);
            for (c, cell) in row.iter().enumerate() {
                let pad = " ".repeat(widths[c] - cell.chars().count());
                let (before, after) =
                    if right[c] { (pad, String::new()) } else { (String::new(), pad) };
                line += &format!("{before}{cell}{after}  ");
            }
            writeln!(out, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_left_and_numbers_right() {
        let mut table = Table::new(["name", "points"]);
        table.row(["a".into(), "7".into()]);
        table.row(["longer".into(), "1234567".into()]);
        let mut text = Vec::new();
        table.print(&mut text, 1).unwrap();
        let expected = " name     points\n a             7\n longer  1234567\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }
}
