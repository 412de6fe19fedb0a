//! The text of `ScatteringData`: a matrix or a tree.

use super::limits::Limits;
use super::numbers::{Lexer, Misfit, Token};
use crate::tree::{MAX_DEPTH, Rank, TensorTree, TreeBuilder};
use crate::{Error, ErrorClass};

/// What was read, and how many negative values became 0.
pub(crate) struct Scattering<T> {
    pub(crate) data: T,
    pub(crate) negative: usize,
}

/// Why a data block was refused.
#[derive(Debug)]
pub(crate) struct Refusal {
    /// Byte offset in the text, where one is to blame.
    pub(crate) at: Option<usize>,
    pub(crate) class: ErrorClass,
    pub(crate) text: String,
}

impl From<Misfit> for Refusal {
    fn from(misfit: Misfit) -> Self {
        Self { at: Some(misfit.at), class: ErrorClass::Format, text: misfit.text }
    }
}

fn format(at: usize, text: impl Into<String>) -> Refusal {
    Misfit { at, text: text.into() }.into()
}

fn limit(text: String) -> Refusal {
    Refusal { at: None, class: ErrorClass::Limit, text }
}

/// Negative values become 0 and are counted.
fn clamp(value: f32, negative: &mut usize) -> f32 {
    if value < 0.0 {
        *negative += 1;
        return 0.0;
    }
    value
}

/// Reads plain numbers, all that there are.
pub(crate) fn numbers(text: &str, limits: &Limits) -> Result<Scattering<Vec<f32>>, Refusal> {
    let mut lexer = Lexer::new(text);
    // A guess, at most three bytes a number: growing step by step copies more.
    let mut data = Vec::with_capacity(limits.values.min(text.len() / 3));
    let mut negative = 0;
    loop {
        lexer.short_numbers(&mut data, limits.values);
        let at = lexer.offset();
        match lexer.next()? {
            Token::Number(_) if data.len() == limits.values => {
                return Err(limit(format!("more than {} values", limits.values)));
            }
            Token::Number(value) => data.push(clamp(value, &mut negative)),
            Token::End => {
                data.shrink_to_fit();
                return Ok(Scattering { data, negative });
            }
            Token::Open | Token::Close => {
                return Err(format(at, "expected numbers of a matrix, found the brace of a tree"));
            }
        }
    }
}

/// Reads a tensor tree, `node := '{' ( node × 2^rank | number × 2^(rank g) ) '}'`.
///
/// No recursion: depth costs nothing but the stack of the builder.
pub(crate) fn tree(
    text: &str,
    rank: Rank,
    limits: &Limits,
) -> Result<Scattering<TensorTree>, Refusal> {
    let depth_limit = limits.tree_depth.min(MAX_DEPTH);
    let mut lexer = Lexer::new(text);
    let mut builder = TreeBuilder::new(rank);
    let (mut depth, mut count, mut negative) = (0, 0, 0);
    // Whether the last brace was a `{` and it is not known yet what it holds, but for `values`.
    let mut undecided = false;
    let mut values: Vec<f32> = Vec::new();
    loop {
        if undecided {
            lexer.short_numbers(&mut values, limits.values - count);
        }
        let at = lexer.offset();
        let blame =
            |e: Error| Refusal { at: Some(at), class: ErrorClass::Format, text: e.to_string() };
        match lexer.next()? {
            Token::Open if !values.is_empty() => {
                return Err(format(at, "expected a number or '}', found '{'"));
            }
            Token::Open => {
                if undecided {
                    builder.open_branch().map_err(blame)?;
                    depth += 1;
                    if depth > depth_limit {
                        return Err(limit(format!("tree deeper than {depth_limit} levels")));
                    }
                }
                undecided = true;
            }
            Token::Number(_) if !undecided => {
                return Err(format(at, "expected '{' or '}', found a number beside a branch"));
            }
            Token::Number(_) if values.len() == limits.values - count => {
                return Err(limit(format!("more than {} values", limits.values)));
            }
            Token::Number(value) => values.push(clamp(value, &mut negative)),
            Token::Close if undecided && values.is_empty() => {
                return Err(format(at, "expected values between braces, found none"));
            }
            Token::Close if undecided => {
                let log2 = grid_level(values.len(), rank)
                    .ok_or_else(|| format(at, grid_misfit(values.len(), rank)))?;
                if depth + log2 > depth_limit {
                    return Err(limit(format!("tree deeper than {depth_limit} levels")));
                }
                builder.grid(log2, &values).map_err(blame)?;
                count += values.len();
                values.clear();
                undecided = false;
            }
            Token::Close => {
                builder.close_branch().map_err(blame)?;
                depth -= 1;
            }
            Token::End => {
                if undecided || depth > 0 {
                    return Err(format(at, "the tree ends inside braces"));
                }
                let data = builder.finish().map_err(blame)?;
                return Ok(Scattering { data, negative });
            }
        }
    }
}

/// The g of 2^(rank g) values.
fn grid_level(count: usize, rank: Rank) -> Option<u32> {
    let log2 = count.trailing_zeros();
    (count.is_power_of_two() && log2.is_multiple_of(rank.dimensions()))
        .then(|| log2 / rank.dimensions())
}

fn grid_misfit(count: usize, rank: Rank) -> String {
    let children = rank.children();
    format!(
        "expected 1, {children}, {} … values between braces, found {count}",
        children * children
    )
}

/// (rows, columns) row-major → (columns, rows) row-major; where both are the same in place.
pub(super) fn transposed(mut values: Vec<f32>, rows: usize, columns: usize) -> Vec<f32> {
    if rows == columns {
        let mut rest = values.as_mut_slice();
        for r in 0..rows {
            let (row, below) = rest.split_at_mut(columns);
            for (value, column) in row[r + 1..].iter_mut().zip(below.chunks_exact_mut(columns)) {
                std::mem::swap(value, &mut column[r]);
            }
            rest = below;
        }
        return values;
    }
    let mut turned = vec![0.0; rows * columns];
    for (r, row) in values.chunks_exact(columns).enumerate() {
        for (value, column) in row.iter().zip(turned.chunks_exact_mut(rows)) {
            column[r] = *value;
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transposing_exchanges_rows_and_columns() {
        for (rows, columns) in [(5, 5), (3, 7), (7, 3), (1, 4), (1, 1)] {
            let values: Vec<f32> = (0..rows * columns).map(|n| n as f32).collect();
            let turned = transposed(values.clone(), rows, columns);
            for (n, value) in turned.iter().enumerate() {
                assert_eq!(*value, values[n % rows * columns + n / rows], "{rows} {columns} {n}");
            }
        }
    }
}
