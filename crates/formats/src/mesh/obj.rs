//! Wavefront OBJ: `v x y z`, `vt u v`, `vn x y z`, `f v/vt/vn ...`.
//!
//! Indices count from 1, or from the last one backwards where negative. A polygon becomes a fan of triangles around its first corner.
//! Corners with the same (v, vt, vn) share a vertex; vertices are numbered as the faces first name them. The last `o` or `g` before a face
//! names its group. Materials, lines and whatever else a file holds are left aside. Coordinates beyond the third (a weight, a colour) are too.
//! Renderers take the v of an OBJ from the picture's top, so `v` becomes `1 - v` unless the caller says otherwise.
//!
//! Source: Wavefront Technologies, Advanced Visualizer Manual, appendix B1, "Object files".

use super::{FileError, Loaded, MAX_MISTAKES, finish::finish};
use etendue_description::{Group, MeshData};
use glam::{Vec2, Vec3};
use std::borrow::Cow;
use std::ops::Range;

const NONE: u32 = u32::MAX;

/// Reads a mesh; `flip_v` turns v into 1 - v.
pub fn read(bytes: &[u8], flip_v: bool) -> Result<Loaded, Vec<FileError>> {
    let mut reader = Reader::new(bytes);
    reader.run();
    // Faces may name what comes later; only now it is known whether they name what never comes.
    if reader.mistakes.len() < MAX_MISTAKES && !reader.in_range() {
        let limits = reader.counts();
        reader = Reader::new(bytes);
        reader.limits = Some(limits);
        reader.run();
    }
    if reader.mistakes.is_empty() && reader.positions.is_empty() {
        return Err(vec![FileError::file("no line gives a vertex (`v x y z`); is this an OBJ file?")]);
    }
    if !reader.mistakes.is_empty() {
        return Err(reader.mistakes);
    }
    Ok(reader.mesh(flip_v))
}

/// The mesh so far.
struct Reader<'b> {
    bytes: &'b [u8],
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    indices: Vec<[u32; 3]>,
    groups: Vec<Group>,
    /// The vertices of the mesh.
    corners: Vec<Corner>,
    /// The first vertex at each position, the others follow by [`Corner::next`].
    first: Vec<u32>,
    /// The largest index of each sort.
    largest: [u32; 3],
    /// How many of each sort there are in the whole file, once that is known.
    limits: Option<[usize; 3]>,
    mistakes: Vec<FileError>,
}

/// A vertex: a position with texture coordinates and normal, each an index or [`NONE`].
struct Corner {
    key: [u32; 3],
    next: u32,
}

const SORTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

impl<'b> Reader<'b> {
    fn new(bytes: &'b [u8]) -> Self {
        Self {
            bytes,
            positions: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            indices: Vec::new(),
            groups: Vec::new(),
            corners: Vec::new(),
            first: Vec::new(),
            largest: [0; 3],
            limits: None,
            mistakes: Vec::new(),
        }
    }

    fn run(&mut self) {
        let bytes = self.bytes;
        let mut at = 0;
        while at < bytes.len() && self.mistakes.len() < MAX_MISTAKES {
            let mut end = memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |i| at + i);
            let mut line = Cow::Borrowed(trim_end(&bytes[at..end]));
            while line.last() == Some(&b'\\') && end < bytes.len() {
                // The line goes on in the next; the places of mistakes stay those of the bytes.
                let next = end + 1;
                end = memchr::memchr(b'\n', &bytes[next..]).map_or(bytes.len(), |i| next + i);
                let mut whole = bytes[at..end].to_vec();
                whole.truncate(trim_end(&whole).len());
                for i in 0..whole.len() {
                    let blank = whole[i] == b'\\'
                        && whole[i + 1..].iter().find(|b| !b.is_ascii_whitespace() || **b == b'\n') == Some(&b'\n');
                    if blank || whole[i] == b'\n' || whole[i] == b'\r' {
                        whole[i] = b' ';
                    }
                }
                line = Cow::Owned(whole);
            }
            if let Err((word, message)) = self.line(&line) {
                self.mistakes.push(FileError::text(bytes, at + word.start..at + word.end, message));
            }
            at = end + 1;
        }
    }

    /// One line; a mistake is told with its bytes within the line.
    #[inline]
    fn line(&mut self, line: &[u8]) -> Result<(), (Range<usize>, String)> {
        let mut words = Words { line, at: 0 };
        words.skip_blanks();
        match words.line.get(words.at..) {
            Some([b'v', b' ' | b'\t', ..]) => {
                words.at += 1;
                let p = words.floats::<3>("a vertex", true);
                // A bad one counts, lest all that follow have wrong numbers.
                self.positions.push(p.as_ref().map_or(Vec3::ZERO, |&p| Vec3::from(p)));
                p?;
            }
            Some([b'v', b't', b' ' | b'\t', ..]) => {
                words.at += 2;
                let u = words.floats::<1>("a texture coordinate", false);
                words.skip_blanks();
                // A texture in one dimension has no v.
                let has_v = u.is_ok() && words.at < line.len();
                let v = if has_v { words.floats::<1>("a texture coordinate", false) } else { Ok([0.0]) };
                let uv = u.and_then(|u| v.map(|v| Vec2::new(u[0], v[0])));
                self.uvs.push(*uv.as_ref().unwrap_or(&Vec2::ZERO));
                uv?;
            }
            Some([b'v', b'n', b' ' | b'\t', ..]) => {
                words.at += 2;
                let n = words.floats::<3>("a normal", false);
                self.normals.push(n.as_ref().map_or(Vec3::ZERO, |&n| Vec3::from(n)));
                n?;
            }
            Some([b'f', b' ' | b'\t', ..]) => {
                words.at += 1;
                self.face(&mut words)?;
            }
            Some([b'o' | b'g', b' ' | b'\t', ..]) => {
                words.at += 1;
                words.skip_blanks();
                self.group(String::from_utf8_lossy(&line[words.at..]).trim_end().to_owned());
            }
            _ => {}
        }
        Ok(())
    }

    /// What follows belongs to the group `name`.
    fn group(&mut self, name: String) {
        let first = self.indices.len() as u32;
        // A name without faces is none.
        self.groups.pop_if(|last| last.first == first);
        if self.groups.last().is_none_or(|last| last.name != name) {
            self.groups.push(Group { name, first });
        }
    }

    fn face(&mut self, words: &mut Words) -> Result<(), (Range<usize>, String)> {
        let mut fan = [0; 2];
        let mut count = 0;
        loop {
            words.skip_blanks();
            if words.at == words.line.len() {
                return Ok(());
            }
            let vertex = self.corner(words)?;
            match count {
                0 => fan[0] = vertex,
                1 => fan[1] = vertex,
                _ => {
                    self.indices.push([fan[0], fan[1], vertex]);
                    fan[1] = vertex;
                }
            }
            count += 1;
        }
    }

    /// One `v`, `v/vt`, `v//vn` or `v/vt/vn`: the number of its vertex.
    #[inline]
    fn corner(&mut self, words: &mut Words) -> Result<u32, (Range<usize>, String)> {
        let start = words.at;
        let mut key = [NONE; 3];
        for (sort, index) in key.iter_mut().enumerate() {
            let at = words.at;
            match words.integer() {
                Some(i) => *index = self.index(sort, i).map_err(|message| (at..words.at, message))?,
                None if sort == 1 && words.peek() == Some(b'/') => {}
                None => {
                    let word = words.word(start);
                    let text = String::from_utf8_lossy(&words.line[word.clone()]).into_owned();
                    return Err((word, format!("`{text}` is no corner of a face, expected v, v/vt, v//vn or v/vt/vn")));
                }
            }
            if words.peek() != Some(b'/') || sort == 2 {
                break;
            }
            words.at += 1;
            // `v/` and `v/vt/` leave out what they announce.
            if matches!(words.peek(), None | Some(b' ' | b'\t')) {
                break;
            }
        }
        if !matches!(words.peek(), None | Some(b' ' | b'\t' | b'\r')) {
            let word = words.word(start);
            let text = String::from_utf8_lossy(&words.line[word.clone()]).into_owned();
            return Err((word, format!("`{text}` is no corner of a face, expected v, v/vt, v//vn or v/vt/vn")));
        }
        Ok(self.vertex(key))
    }

    /// An index from 0 for one from 1, or from the end where negative.
    #[inline]
    fn index(&mut self, sort: usize, i: i64) -> Result<u32, String> {
        let here = self.counts()[sort];
        let index = if i > 0 { i - 1 } else { here as i64 + i };
        if i == 0 {
            return Err(format!("{} 0 does not exist, indices begin with 1", SORTS[sort]));
        }
        // No file has more of a sort than it has lines for.
        let limit = self.limits.map_or(self.bytes.len() / 4 + 1, |limits| limits[sort]);
        if index < 0 || index as u64 >= (limit as u64).min(u64::from(NONE)) {
            let known = self.limits.map_or(here, |limits| limits[sort]);
            return Err(format!("{} {i} does not exist, there are {known}", SORTS[sort]));
        }
        self.largest[sort] = self.largest[sort].max(index as u32);
        Ok(index as u32)
    }

    /// The vertex of a key, a new one at the first time.
    #[inline]
    fn vertex(&mut self, key: [u32; 3]) -> u32 {
        let position = key[0] as usize;
        if position >= self.first.len() {
            self.first.resize((position + 1).max(self.positions.len()), NONE);
        }
        let new = self.corners.len() as u32;
        let mut at = self.first[position];
        if at == NONE {
            self.first[position] = new;
        }
        while at != NONE {
            let corner = &mut self.corners[at as usize];
            if corner.key == key {
                return at;
            }
            at = corner.next;
            if at == NONE {
                corner.next = new;
            }
        }
        self.corners.push(Corner { key, next: NONE });
        new
    }

    fn counts(&self) -> [usize; 3] {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    fn in_range(&self) -> bool {
        let counts = self.counts();
        (0..3).all(|sort| (self.largest[sort] as usize) < counts[sort].max(1))
            && (self.corners.is_empty() || !self.positions.is_empty())
            && self.corners.iter().all(|c| (1..3).all(|sort| c.key[sort] == NONE || (c.key[sort] as usize) < counts[sort]))
    }

    fn mesh(self, flip_v: bool) -> Loaded {
        let Self { positions, uvs, normals, corners, indices, mut groups, .. } = self;
        groups.retain(|g| (g.first as usize) < indices.len());
        let uv = |i: u32| uvs.get(i as usize).map_or(Vec2::ZERO, |t| if flip_v { Vec2::new(t.x, 1.0 - t.y) } else { *t });
        let any = |sort: usize| corners.iter().any(|c| c.key[sort] != NONE);
        let mut mesh = MeshData { indices, groups, ..MeshData::default() };
        mesh.positions = corners.iter().map(|c| positions[c.key[0] as usize]).collect();
        if any(1) {
            mesh.uvs = corners.iter().map(|c| uv(c.key[1])).collect();
        }
        let mut unusable = 0;
        if any(2) {
            unusable = corners.iter().filter(|c| normals.get(c.key[2] as usize) == Some(&Vec3::ZERO)).count();
            mesh.normals = corners.iter().map(|c| normals.get(c.key[2] as usize).copied().unwrap_or(Vec3::ZERO)).collect();
        }
        finish(mesh, unusable)
    }
}

/// The words of one line.
struct Words<'l> {
    line: &'l [u8],
    at: usize,
}

impl Words<'_> {
    #[inline]
    fn peek(&self) -> Option<u8> {
        self.line.get(self.at).copied()
    }

    #[inline]
    fn skip_blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
    }

    /// The word around or behind `start`.
    fn word(&self, start: usize) -> Range<usize> {
        let end = self.line[start..].iter().position(|b| b.is_ascii_whitespace()).map_or(self.line.len(), |i| start + i);
        start..end
    }

    /// `N` numbers in a row.
    #[inline]
    fn floats<const N: usize>(&mut self, what: &str, finite: bool) -> Result<[f32; N], (Range<usize>, String)> {
        let mut out = [0.0; N];
        for x in &mut out {
            self.skip_blanks();
            let parsed = fast_float2::parse_partial::<f32, _>(&self.line[self.at..]).ok();
            let ends = |digits: usize| matches!(self.line.get(self.at + digits), None | Some(b' ' | b'\t' | b'\r'));
            match parsed.filter(|(_, digits)| ends(*digits)) {
                Some((value, digits)) if !finite || value.is_finite() => {
                    *x = value;
                    self.at += digits;
                }
                _ if self.at == self.line.len() => {
                    return Err((0..self.line.len(), format!("a number is missing: {what} has {N}")));
                }
                parsed => {
                    let word = self.word(self.at);
                    let text = String::from_utf8_lossy(&self.line[word.clone()]).into_owned();
                    let kind = if parsed.is_some() { "finite number" } else { "number" };
                    return Err((word, format!("`{text}` is no {kind}")));
                }
            }
        }
        Ok(out)
    }

    /// A whole number with an optional sign; `None` leaves the place.
    #[inline]
    fn integer(&mut self) -> Option<i64> {
        let negative = self.peek() == Some(b'-');
        let start = self.at + usize::from(negative || self.peek() == Some(b'+'));
        let mut at = start;
        let mut value: i64 = 0;
        while let Some(digit @ b'0'..=b'9') = self.line.get(at) {
            value = value.saturating_mul(10).saturating_add(i64::from(digit - b'0'));
            at += 1;
        }
        if at == start {
            return None;
        }
        self.at = at;
        Some(if negative { -value } else { value })
    }
}

#[inline]
fn trim_end(mut line: &[u8]) -> &[u8] {
    while let [rest @ .., b' ' | b'\t' | b'\r'] = line {
        line = rest;
    }
    line
}
