//! Reads the elements of glTF accessors, such as the positions of vertices. Every range of bytes is checked, in arithmetic
//! that cannot overflow, before its first byte is read. The number of elements that a file states may be wrong, so it is
//! checked before memory for that number is allocated.

use super::buffers::Content;
use super::damaged;
use super::document::{Accessor, Document};
use super::unfolding::Unfolding;
use crate::{Error, Result};
use glam::{Vec2, Vec3, Vec4};

/// The bytes of an element of an accessor without a buffer view: such elements are 0 and not stored in the file. The largest
/// element has 16 bytes, four floats.
const ZEROS: [u8; 16] = [0; 16];

/// The maximum number of elements (1,048,576) that an accessor without a buffer view may have if an animation uses it; a
/// file with more is refused. The elements of such an accessor are 0 and take no bytes in the file, so a wrong number of
/// elements could otherwise fill the memory with zeros.
const MAX_ZEROS: u64 = 1 << 20;

/// A reader of the accessors of a glTF document. It returns vertices and indices of meshes, keyframes of
/// animations and the bytes of images from the buffers of the file.
#[derive(Clone, Copy)]
pub struct Accessors<'a> {
    pub document: &'a Document,
    pub buffers: &'a [Content<'a>],
    /// The memory that elements may still take when they are copied from the file's buffers, in bytes. Each read of elements
    /// subtracts what they take, and fails if too little is left. Thus a small file whose elements share bytes cannot fill
    /// the memory.
    pub unfolding: &'a Unfolding,
}

/// The type of the elements of a vertex attribute: vectors of two, three or four components. The code that reads an
/// attribute states the types that it accepts, such as three components for positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Vec2,
    Vec3,
    Vec4,
}

impl Kind {
    /// The name of the type in glTF's JSON, such as `VEC3`. The `type` of an accessor is compared with it,
    /// and messages show it.
    const fn name(self) -> &'static str {
        match self {
            Self::Vec2 => "VEC2",
            Self::Vec3 => "VEC3",
            Self::Vec4 => "VEC4",
        }
    }

    const fn components(self) -> usize {
        match self {
            Self::Vec2 => 2,
            Self::Vec3 => 3,
            Self::Vec4 => 4,
        }
    }
}

/// The elements of one accessor, such as the positions of vertices. [`Accessors`] has checked that all
/// `count` elements lie in the buffers, so reading an element cannot fail.
pub struct Elements<'a> {
    pub count: u64,
    component: Component,
    normalized: bool,
    size: usize,
    dense: Option<Strided<'a>>,
    sparse: Option<Replaced<'a>>,
}

struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// The replacements in a sparse accessor: the indices of the replaced elements, in ascending order, and the new value of
/// each. All other elements come from the accessor's buffer view, or are 0 if it has none.
struct Replaced<'a> {
    indices: Vec<u64>,
    values: Strided<'a>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// The component type with the number `code` in glTF's `componentType`, such as floats for 5126; `None` for an unknown
    /// number, with which a file is refused.
    fn of(code: u64) -> Option<Self> {
        match code {
            5120 => Some(Self::I8),
            5121 => Some(Self::U8),
            5122 => Some(Self::I16),
            5123 => Some(Self::U16),
            5125 => Some(Self::U32),
            5126 => Some(Self::F32),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// True for the unsigned integers, which are the types that vertex indices can have. Indices of other types are refused.
    fn is_index(self) -> bool {
        matches!(self, Self::U8 | Self::U16 | Self::U32)
    }

    /// Decodes one component from the first bytes of `bytes`. If `normalized` is true, an integer is divided by the largest
    /// value of its type: the result is in [0, 1] for unsigned types and in [−1, 1] for signed ones. Otherwise, and for
    /// floats, the number is returned unchanged.
    fn number(self, bytes: &[u8], normalized: bool) -> f64 {
        let (number, one) = match (self, bytes) {
            (Self::I8, &[a, ..]) => (f64::from(a as i8), 127.0),
            (Self::U8, &[a, ..]) => (f64::from(a), 255.0),
            (Self::I16, &[a, b, ..]) => (f64::from(i16::from_le_bytes([a, b])), 32767.0),
            (Self::U16, &[a, b, ..]) => (f64::from(u16::from_le_bytes([a, b])), 65535.0),
            (_, &[a, b, c, d, ..]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => unreachable!("an element is as long as its component"),
        };
        if normalized {
            (number / one).max(-1.0)
        } else {
            number
        }
    }

    fn index(self, bytes: &[u8]) -> u64 {
        match (self, bytes) {
            (Self::U8, &[a, ..]) => u64::from(a),
            (Self::U16, &[a, b, ..]) => u64::from(u16::from_le_bytes([a, b])),
            (_, &[a, b, c, d, ..]) => u64::from(u32::from_le_bytes([a, b, c, d])),
            _ => unreachable!("an element is as long as its component"),
        }
    }
}

impl<'a> Accessors<'a> {
    /// The elements of the accessor at `index` in the file as a vertex attribute. The accessor must have one of the types
    /// `kinds`, and components that are floats or integers of 8 or 16 bits, normalized or not (`KHR_mesh_quantization`).
    /// `used_as` says in messages what the accessor is used for. Fails if a type is wrong, or if elements lie outside of
    /// their buffer.
    pub fn attribute(&self, index: u64, used_as: &str, kinds: &[Kind]) -> Result<Elements<'a>> {
        let (what, accessor) = self.accessor(index, used_as)?;
        let component = Component::of(accessor.component_type).filter(|c| *c != Component::U32);
        let kind = kinds.iter().find(|kind| kind.name() == accessor.kind);
        let (Some(component), Some(kind)) = (component, kind) else {
            let names: Vec<&str> = kinds.iter().map(|kind| kind.name()).collect();
            let wanted = format!(
                "{} of floats (5126) or of integers of 8 or 16 bits",
                names.join(" or ")
            );
            return Err(wrong_type(&what, accessor, &wanted));
        };
        self.elements(
            &what,
            accessor,
            component,
            kind.components() * component.size(),
        )
    }

    /// The elements of the accessor at `index` as [`Self::attribute`] reads them, for vertices of which there are `positions`.
    /// Fails also if the accessor has another number of elements.
    pub fn vertex_attribute(
        &self,
        index: u64,
        used_as: &str,
        kinds: &[Kind],
        positions: u64,
    ) -> Result<Elements<'a>> {
        let found = self.attribute(index, used_as, kinds)?;
        if found.count != positions {
            return Err(damaged(format!(
                "accessor {index} ({used_as}): has {} elements for {positions} positions",
                found.count
            )));
        }
        Ok(found)
    }

    /// The elements of the accessor at `index` in the file as vertex indices: unsigned integers of 8, 16 or 32 bits.
    /// `used_as` says in messages what the accessor is used for. Fails if the type is wrong, or if elements lie outside of
    /// their buffer.
    pub fn indices(&self, index: u64, used_as: &str) -> Result<Elements<'a>> {
        let (what, accessor) = self.accessor(index, used_as)?;
        match Component::of(accessor.component_type) {
            Some(component) if accessor.kind == "SCALAR" && component.is_index() => {
                self.elements(&what, accessor, component, component.size())
            }
            _ => Err(wrong_type(
                &what,
                accessor,
                "SCALAR of unsigned integers (5121, 5123 or 5125)",
            )),
        }
    }

    /// All numbers of the accessor at `index` in the file, element by element, for animations. Its elements must have the
    /// type `kind`, such as `VEC3` with 3 `components`, and be floats or, if `floats_only` is false, normalized integers.
    /// `used_as` says in messages what the accessor is used for. Fails if the type is wrong, if elements lie outside of
    /// their buffer, or if the file takes too much memory.
    pub fn numbers(
        &self,
        index: u64,
        used_as: &str,
        (kind, components): (&str, usize),
        floats_only: bool,
    ) -> Result<Vec<f64>> {
        let (what, accessor) = self.accessor(index, used_as)?;
        let component = Component::of(accessor.component_type).filter(|&c| match c {
            Component::F32 => true,
            Component::U32 => false,
            _ => accessor.normalized && !floats_only,
        });
        let Some(component) = component.filter(|_| accessor.kind == kind) else {
            let or = if floats_only {
                ""
            } else {
                " or normalized integers"
            };
            return Err(Error::input(format!(
                "{what}: is {} of component type {}{}, it must be {kind} of floats (5126){or}",
                crate::scene::notices::quoted(&accessor.kind),
                accessor.component_type,
                if accessor.normalized {
                    ", normalized"
                } else {
                    ""
                },
            )));
        };
        let size = components * component.size();
        // Without a view all elements are zero, and their number a mere claim.
        if accessor.buffer_view.is_none() && accessor.count > MAX_ZEROS {
            return Err(damaged(format!(
                "{what}: it has {} elements, but no bufferView",
                accessor.count
            )));
        }
        let elements = self.elements(&what, accessor, component, size)?;
        // As f64, and again as what is made of them.
        let bytes = 2 * size_of::<f64>() * components;
        (self.unfolding).take(&what, u128::from(accessor.count) * bytes as u128)?;
        let of_element = |i: u64| {
            let bytes = elements.element(i as usize);
            bytes
                .chunks(component.size())
                .map(move |b| component.number(b, true))
        };
        Ok((0..elements.count).flat_map(of_element).collect())
    }

    fn accessor(&self, index: u64, used_as: &str) -> Result<(String, &'a Accessor)> {
        let what = format!("accessor {index} ({used_as})");
        match get(&self.document.accessors, index) {
            Some(accessor) => Ok((what, accessor)),
            None => Err(damaged(format!(
                "{what} is out of range, there are {}",
                self.document.accessors.len()
            ))),
        }
    }

    fn elements(
        &self,
        what: &str,
        accessor: &'a Accessor,
        component: Component,
        size: usize,
    ) -> Result<Elements<'a>> {
        let Accessor {
            byte_offset, count, ..
        } = *accessor;
        let dense = match accessor.buffer_view {
            Some(view) => Some(self.range(what, view, byte_offset, count, size, true)?),
            None => None,
        };
        let sparse = match &accessor.sparse {
            None => None,
            Some(sparse) => {
                let part = format!("{what}, sparse indices");
                let code = sparse.indices.component_type;
                let Some(kind) = Component::of(code).filter(|c| c.is_index()) else {
                    return Err(damaged(format!(
                        "{part}: component type {code} is not an unsigned integer"
                    )));
                };
                let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset);
                let found = self.range(&part, view, offset, sparse.count, kind.size(), false)?;
                let part = format!("{what}, sparse values");
                let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
                let values = self.range(&part, view, offset, sparse.count, size, false)?;
                (self.unfolding).take(&part, u128::from(sparse.count) * 8)?;
                // The ranges just checked hold this many.
                let indices: Vec<u64> = (0..sparse.count as usize)
                    .map(|i| kind.index(found.element(i, kind.size())))
                    .collect();
                let increase = indices.windows(2).all(|pair| pair[0] < pair[1]);
                if !increase || indices.last().is_some_and(|&last| last >= count) {
                    return Err(damaged(format!(
                        "{what}: its sparse indices do not increase within its count {count}"
                    )));
                }
                Some(Replaced { indices, values })
            }
        };
        Ok(Elements {
            count,
            component,
            normalized: accessor.normalized,
            size,
            dense,
            sparse,
        })
    }

    /// The message that the file of a buffer is missing, if the accessor with the index `accessor` reads from this buffer.
    /// `None` if the buffer is there, and also if the accessor is wrong, which its reader reports.
    pub fn missing_buffer(&self, accessor: Option<u64>) -> Option<&'a str> {
        let accessor = get(&self.document.accessors, accessor?)?;
        let view = get(&self.document.buffer_views, accessor.buffer_view?)?;
        get(self.buffers, view.buffer)?.err()
    }

    /// The bytes of the buffer view at the index `view` in the file, from which elements or an encoded image
    /// are read. `what` is the element that uses the view, for messages. Fails if the view or its buffer does
    /// not exist, or if the view extends beyond its buffer.
    pub fn view(&self, what: &str, view: u64) -> Result<&'a [u8]> {
        let views = &self.document.buffer_views;
        let Some(found) = get(views, view) else {
            return Err(damaged(format!(
                "{what}: bufferView {view} is out of range, there are {}",
                views.len()
            )));
        };
        let range = (found.byte_offset, found.byte_length);
        self.bytes(&format!("bufferView {view}"), found.buffer, range)
    }

    /// The bytes of the buffer at the index `buffer` that begin at byte `offset` and are `length` bytes long. `what` names
    /// the user of these bytes in messages. Fails if there is no such buffer, or if it has fewer bytes.
    pub fn bytes(&self, what: &str, buffer: u64, (offset, length): (u64, u64)) -> Result<&'a [u8]> {
        let Some(bytes) = get(self.buffers, buffer) else {
            return Err(damaged(format!(
                "{what}: buffer {buffer} is out of range, there are {}",
                self.buffers.len()
            )));
        };
        let bytes = bytes.map_err(Error::input)?;
        let end = u128::from(offset) + u128::from(length);
        if end > bytes.len() as u128 {
            return Err(damaged(format!(
                "{what} ends at byte {end}, but buffer {buffer} has {}",
                bytes.len()
            )));
        }
        Ok(&bytes[offset as usize..end as usize])
    }

    /// The bytes of `count` elements of `size` bytes each, which start at byte `offset` of the buffer view with the index
    /// `view`. If `strided` is true and the view states a `byteStride`, the starts of two successive elements are this many
    /// bytes apart; otherwise the elements are adjacent. `what` names the elements in messages. Fails if the elements extend
    /// beyond the view, or if the `byteStride` is less than `size` or above 252 bytes.
    fn range(
        &self,
        what: &str,
        view: u64,
        offset: u64,
        count: u64,
        size: usize,
        strided: bool,
    ) -> Result<Strided<'a>> {
        let bytes = self.view(what, view)?;
        let stride = match self.document.buffer_views[view as usize].byte_stride {
            Some(stride) if strided => stride,
            _ => size as u64,
        };
        if stride < size as u64 || stride > 252 {
            return Err(damaged(format!(
                "{what}: bufferView {view} has the byteStride {stride}; it must be from {size} to 252"
            )));
        }
        let end = match count {
            0 => 0,
            _ => u128::from(offset) + u128::from(count - 1) * u128::from(stride) + size as u128,
        };
        if end > bytes.len() as u128 {
            return Err(damaged(format!(
                "{what}: its {count} elements end at byte {end}, but bufferView {view} has {}",
                bytes.len()
            )));
        }
        Ok(Strided {
            bytes: bytes.get(offset as usize..).unwrap_or_default(),
            stride: stride as usize,
        })
    }
}

impl Strided<'_> {
    fn element(&self, index: usize, size: usize) -> &[u8] {
        let start = index * self.stride;
        &self.bytes[start..start + size]
    }
}

impl Elements<'_> {
    /// The vertex index that the element at `index` contains, counted from 0 among the vertices of the
    /// primitive. The element must be one unsigned integer, as [`Accessors::indices`] ensures.
    pub fn index(&self, index: u64) -> u64 {
        self.component.index(self.element(index as usize))
    }

    /// The first three components of the element at `index`, such as a position or a normal. Normalized integers become
    /// numbers in [0, 1] or [−1, 1]; other components are returned unchanged.
    pub fn vector(&self, index: u64) -> Vec3 {
        Vec3::new(
            self.number(index, 0),
            self.number(index, 1),
            self.number(index, 2),
        )
    }

    /// The element at `index` as a colour: RGBA, with the alpha 1 (opaque) if the elements have only three components.
    /// Normalized integers become numbers in [0, 1].
    pub fn color(&self, index: u64) -> Vec4 {
        let opaque = self.size < 4 * self.component.size();
        let alpha = if opaque { 1.0 } else { self.number(index, 3) };
        self.vector(index).extend(alpha)
    }

    /// The four components of the element at `index`, such as a tangent with its sign. Normalized integers become numbers in
    /// [0, 1] or [−1, 1]; other components are returned unchanged.
    pub fn quadruple(&self, index: u64) -> Vec4 {
        self.vector(index).extend(self.number(index, 3))
    }

    /// One component of the element at `index`, converted to f32 after [`Component::number`] has decoded it. `component`
    /// counts the components from 0.
    fn number(&self, index: u64, component: usize) -> f32 {
        let bytes = &self.element(index as usize)[component * self.component.size()..];
        self.component.number(bytes, self.normalized) as f32
    }

    /// The first two components of the element at `index`, such as texture coordinates. Normalized integers become numbers
    /// in [0, 1] or [−1, 1]; other components are returned unchanged.
    pub fn pair(&self, index: u64) -> Vec2 {
        Vec2::new(self.number(index, 0), self.number(index, 1))
    }

    fn element(&self, index: usize) -> &[u8] {
        debug_assert!((index as u64) < self.count);
        if let Some(sparse) = &self.sparse
            && let Ok(found) = sparse.indices.binary_search(&(index as u64))
        {
            return sparse.values.element(found, self.size);
        }
        match &self.dense {
            Some(dense) => dense.element(index, self.size),
            None => &ZEROS[..self.size],
        }
    }
}

/// The item of `items` at `index`, which a file states. `None` if the index is out of range, so that a damaged file causes
/// no panic.
pub fn get<T>(items: &[T], index: u64) -> Option<&T> {
    items.get(usize::try_from(index).ok()?)
}

fn wrong_type(what: &str, accessor: &Accessor, wanted: &str) -> Error {
    Error::input(format!(
        "{what}: is {} of component type {}, it must be {wanted}",
        crate::scene::notices::quoted(&accessor.kind),
        accessor.component_type,
    ))
}
