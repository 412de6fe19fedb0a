//! The outline of an XML file: where each element is. Text stays in the source, unread.

use std::borrow::Cow;
use std::ops::Range;

use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::attributes::Attributes;
use quick_xml::events::{BytesRef, Event};

use super::limits::Limits;
use super::report::{Fault, Report};

/// An XML file as a flat list of elements in document order.
///
/// Holds spans of the source, so that tens of megabytes of numbers are neither copied nor looked
/// at before their meaning is known, and unknown elements can be kept as they were written.
/// Entities beyond the five of XML and character references are faults, so nothing expands.
/// Cost: one pass; no recursion.
pub(crate) struct Document<'a> {
    pub(crate) source: &'a str,
    elements: Vec<Element<'a>>,
    /// Comments with their marks, each with the element that it stands in.
    comments: Vec<(Option<usize>, &'a str)>,
}

struct Element<'a> {
    /// Name without namespace prefix.
    name: &'a str,
    parent: Option<usize>,
    /// One past the last descendant.
    subtree_end: usize,
    /// From `<` of the start tag to past `>` of the end tag.
    outer: Range<usize>,
    /// Between the tags.
    inner: Range<usize>,
    /// Whether anything but characters is in there: elements, references, comments, CDATA.
    markup: bool,
}

/// An element of a [`Document`].
#[derive(Clone, Copy)]
pub(crate) struct Node<'d, 'a> {
    document: &'d Document<'a>,
    id: usize,
}

impl<'a> Document<'a> {
    /// Finds all elements. `None` when the file is not well-formed, with the fault in `report`.
    pub(crate) fn parse(source: &'a str, limits: &Limits, report: &mut Report) -> Option<Self> {
        let mut document = Self { source, elements: Vec::new(), comments: Vec::new() };
        match document.scan(limits, report) {
            Ok(()) => Some(document),
            Err(fault) => {
                report.fault(fault);
                None
            }
        }
    }

    fn scan(&mut self, limits: &Limits, report: &mut Report) -> Result<(), Fault> {
        let source = self.source;
        let at = |offset: usize| format!("line {}", line_of(source, offset));
        let mut reader = Reader::from_str(source);
        let mut open: Vec<usize> = Vec::new();
        loop {
            let start = reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|e| {
                Fault::format(at(reader.error_position() as usize), format!("malformed XML: {e}"))
            })?;
            let end = reader.buffer_position() as usize;
            let empty = matches!(event, Event::Empty(_));
            if let Some(&id) = open.last()
                && !matches!(event, Event::Text(_) | Event::End(_))
            {
                self.elements[id].markup = true;
            }
            match event {
                Event::Start(tag) | Event::Empty(tag) => {
                    if self.elements.len() >= limits.elements {
                        let text = format!("more than {} elements", limits.elements);
                        return Err(Fault::limit(at(start), text));
                    }
                    if open.len() >= limits.element_depth {
                        let text = format!("elements nested deeper than {}", limits.element_depth);
                        return Err(Fault::limit(at(start), text));
                    }
                    if open.is_empty() && !self.elements.is_empty() {
                        return Err(Fault::format(at(start), "a second root element"));
                    }
                    let name_length = tag.name().into_inner().len();
                    let mut attributes = Attributes::new(&tag, name_length);
                    if let Some(Err(e)) = attributes.with_checks(false).find(Result::is_err) {
                        return Err(Fault::format(at(start), format!("malformed attribute: {e}")));
                    }
                    let name = &source[start + 1..start + 1 + name_length];
                    let id = self.elements.len();
                    self.elements.push(Element {
                        name: name.rsplit(':').next().unwrap_or(name),
                        parent: open.last().copied(),
                        subtree_end: id + 1,
                        outer: start..end,
                        inner: end..end,
                        markup: false,
                    });
                    if !empty {
                        open.push(id);
                    }
                }
                Event::End(_) => {
                    // The reader has checked that the names match.
                    let Some(id) = open.pop() else {
                        return Err(Fault::format(at(start), "an end tag without start tag"));
                    };
                    let subtree_end = self.elements.len();
                    let element = &mut self.elements[id];
                    element.inner.end = start;
                    element.outer.end = end;
                    element.subtree_end = subtree_end;
                }
                Event::GeneralRef(reference) => {
                    resolve(&reference).map_err(|text| Fault::format(at(start), text))?;
                }
                Event::Comment(_) => {
                    self.comments.push((open.last().copied(), &source[start..end]));
                }
                Event::Text(text) if open.is_empty() && !text.trim().is_empty() => {
                    if self.elements.is_empty() && text.trim_start().starts_with(['{', '[', '#']) {
                        return Err(Fault::format(at(start), "expected XML, found other text"));
                    }
                    let text = "text outside the root element is ignored";
                    report.warn("outside-text", at(start), text);
                }
                Event::Eof => break,
                _ => {}
            }
        }
        if let Some(&id) = open.last() {
            let node = Node { document: self, id };
            let text = format!("file ends inside {}", node.path());
            return Err(Fault::format(at(source.len()), text));
        }
        if self.elements.is_empty() {
            return Err(Fault::format(String::new(), "expected XML, found no element"));
        }
        Ok(())
    }

    /// Comments outside every element and directly inside these, without their marks.
    pub(crate) fn comments(&self, parents: &[Node<'_, 'a>]) -> impl Iterator<Item = &'a str> {
        let inside = |id: &Option<usize>| id.is_none_or(|id| parents.iter().any(|p| p.id == id));
        let wanted = self.comments.iter().filter(move |(parent, _)| inside(parent));
        wanted.map(|(_, text)| {
            text.strip_prefix("<!--").unwrap_or(text).strip_suffix("-->").unwrap_or(text).trim()
        })
    }

    /// The root element.
    pub(crate) fn root(&self) -> Node<'_, 'a> {
        Node { document: self, id: 0 }
    }
}

impl<'d, 'a> Node<'d, 'a> {
    fn element(self) -> &'d Element<'a> {
        &self.document.elements[self.id]
    }

    /// Name without namespace prefix.
    pub(crate) fn name(self) -> &'a str {
        self.element().name
    }

    /// Child elements in document order.
    pub(crate) fn children(self) -> impl Iterator<Item = Node<'d, 'a>> {
        let end = self.element().subtree_end;
        let mut id = self.id + 1;
        std::iter::from_fn(move || {
            (id < end).then(|| {
                let node = Node { document: self.document, id };
                id = node.element().subtree_end;
                node
            })
        })
    }

    /// Child elements of that name.
    pub(crate) fn children_named(self, name: &'d str) -> impl Iterator<Item = Node<'d, 'a>> {
        self.children().filter(move |child| child.name() == name)
    }

    /// First child element of that name.
    pub(crate) fn child(self, name: &str) -> Option<Node<'d, 'a>> {
        self.children().find(|child| child.name() == name)
    }

    /// Whether it has neither attributes nor child elements: all of it is its text.
    pub(crate) fn is_plain(self) -> bool {
        self.children().next().is_none() && !self.tag().trim_end().contains(char::is_whitespace)
    }

    /// What stands between `<` and `>` (or `/>`) of the start tag.
    fn tag(self) -> &'a str {
        let Element { outer, inner, .. } = self.element();
        let tag = &self.document.source[outer.start + 1..inner.start];
        let tag = tag.strip_suffix('>').unwrap_or(tag);
        tag.strip_suffix('/').unwrap_or(tag)
    }

    /// Value of an attribute, trimmed, references resolved.
    pub(crate) fn attribute(self, name: &str) -> Option<String> {
        let tag = self.tag();
        let name_length = tag.find(|c: char| c.is_ascii_whitespace()).unwrap_or(tag.len());
        let mut attributes = Attributes::new(tag, name_length);
        let attribute = attributes
            .with_checks(false)
            .flatten()
            .find(|a| a.key.local_name().into_inner() == name)?;
        let value = unescape(&attribute.value).unwrap_or(Cow::Borrowed(&attribute.value));
        Some(value.trim().to_owned())
    }

    /// Character data directly inside, CDATA included, references resolved, not trimmed.
    ///
    /// Borrowed from the source unless it contains markup.
    pub(crate) fn text(self) -> Cow<'a, str> {
        let Element { inner, markup, .. } = self.element();
        let inner = &self.document.source[inner.clone()];
        if !markup {
            return Cow::Borrowed(inner);
        }
        let mut reader = Reader::from_str(inner);
        let mut depth = 0;
        let mut text = String::new();
        // The scan has read this span before without error.
        while let Ok(event) = reader.read_event() {
            match event {
                Event::Start(_) => depth += 1,
                Event::End(_) => depth -= 1,
                Event::Text(part) if depth == 0 => text.push_str(&part),
                Event::CData(part) if depth == 0 => text.push_str(&part),
                Event::GeneralRef(part) if depth == 0 => text.extend(resolve(&part)),
                Event::Eof => break,
                _ => {}
            }
        }
        Cow::Owned(text)
    }

    /// The element as it was written.
    pub(crate) fn verbatim(self) -> &'a str {
        &self.document.source[self.element().outer.clone()]
    }

    /// Where its content stands in the source.
    pub(crate) fn inner(self) -> Range<usize> {
        self.element().inner.clone()
    }

    /// Where it is, for messages: `line 12: Optical/Layer/WavelengthData[2]/ScatteringData`.
    pub(crate) fn place(self) -> String {
        let line = line_of(self.document.source, self.element().outer.start);
        format!("line {line}: {}", self.path())
    }

    /// Where byte `offset` of a borrowed [`text`](Self::text) is.
    pub(crate) fn place_in_text(self, offset: usize) -> String {
        let line = line_of(self.document.source, self.element().inner.start + offset);
        format!("line {line}: {}", self.path())
    }

    /// Names from below the root, numbered where siblings share a name.
    fn path(self) -> String {
        let mut names = Vec::new();
        let mut node = self;
        while let Some(parent) = node.element().parent {
            let parent = Node { document: self.document, id: parent };
            let twins = || parent.children_named(node.name());
            names.push(if twins().nth(1).is_some() {
                format!("{}[{}]", node.name(), 1 + twins().take_while(|t| t.id < node.id).count())
            } else {
                node.name().to_owned()
            });
            node = parent;
        }
        if names.is_empty() {
            return node.name().to_owned();
        }
        names.reverse();
        names.join("/")
    }
}

/// The character that a reference stands for: one of XML's five or a number.
fn resolve(reference: &BytesRef<'_>) -> Result<char, String> {
    match reference.resolve_char_ref() {
        Ok(Some(c)) => return Ok(c),
        Ok(None) => {}
        Err(e) => return Err(format!("bad character reference: {e}")),
    }
    match &**reference {
        "amp" => Ok('&'),
        "lt" => Ok('<'),
        "gt" => Ok('>'),
        "quot" => Ok('"'),
        "apos" => Ok('\''),
        name => Err(format!("entity &{};: only the five of XML itself are read", clip(name))),
    }
}

/// At most 40 characters of `text`, for messages.
pub(crate) fn clip(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

/// The line, from 1, of a byte of `source`.
pub(crate) fn line_of(source: &str, offset: usize) -> usize {
    let before = &source.as_bytes()[..offset.min(source.len())];
    1 + before.iter().filter(|&&b| b == b'\n').count()
}
