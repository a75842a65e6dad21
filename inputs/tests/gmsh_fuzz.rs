//! Mutated mesh files: every one is read or refused; nothing panics, hangs or asks for endless memory.

mod chance;
mod gmsh;

use chance::Chance;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use hati_inputs::InputError;
use hati_inputs::gmsh::{GmshMesh, read};

/// Words that readers of text trip over.
const WORDS: [&[u8]; 16] = [
    b"NaN",
    b"inf",
    b"1e400",
    b"-1",
    b" 0 ",
    b"99999999999",
    b"18446744073709551615",
    b"-9223372036854775808",
    b"2147483648",
    b"$EndNodes\n",
    b"\n$Nodes\n",
    b"$",
    b"\r",
    b"\0",
    b"\xff\xfe",
    b"\xff\xff\xff\xff\xff\xff\xff\x7f",
];

/// One to four changes: bits, bytes, words, digits, blocks taken out, doubled or moved, the end cut off.
fn mutate(seed: &[u8], chance: &mut Chance) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=chance.below(4) {
        if bytes.is_empty() {
            break;
        }
        let at = chance.below(bytes.len());
        let scale = chance.below(9);
        let end = (at + 1 + chance.below(1 << scale)).min(bytes.len());
        let word = WORDS[chance.below(WORDS.len())];
        match chance.below(12) {
            0 => bytes[at] ^= 1 << chance.below(8),
            1 => bytes[at] = chance.next() as u8,
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let block = bytes[at..end].to_vec();
                let to = chance.below(bytes.len());
                bytes.splice(to..to, block);
            }
            5 => drop(bytes.splice(at..at, word.iter().copied())),
            6 => drop(bytes.splice(at..(at + word.len()).min(bytes.len()), word.iter().copied())),
            7 => bytes[at..end].iter_mut().for_each(|byte| *byte = chance.next() as u8),
            // Digits most of all: counts, tags and coordinates that are numbers still.
            _ => {
                if let Some(digit) = bytes[at..].iter().position(u8::is_ascii_digit) {
                    bytes[at + digit] = b'0' + chance.below(10) as u8;
                }
            }
        }
    }
    bytes
}

/// Whether a mesh that was read is what its documentation says.
fn is_sound(mesh: &GmshMesh) -> bool {
    let per_element = (mesh.order + 1).pow(mesh.dimension as u32);
    let sides = mesh.boundaries.iter().flat_map(|(_, sides)| sides);
    let count = mesh.material.len();
    (1..=2).contains(&mesh.order)
        && (2..=3).contains(&mesh.dimension)
        && count > 0
        && mesh.tags.len() == count
        && mesh.elements.len() == count * per_element
        && mesh.elements.iter().all(|node| (*node as usize) < mesh.nodes.len())
        && mesh.nodes.iter().flatten().all(|c| c.is_finite())
        && mesh.material.iter().all(|material| (*material as usize) < mesh.materials.len())
        && sides.into_iter().all(|(e, s)| (*e as usize) < count && usize::from(*s) < 2 * mesh.dimension)
        && mesh.materials.iter().all(|name| gmsh::measure(mesh, name) > 0.0)
}

fn fuzz(count: usize, salt: u64) {
    let folder = tempfile::tempdir().unwrap();
    let mut seeds: Vec<_> =
        std::fs::read_dir(gmsh::fixture("")).unwrap().map(|e| e.unwrap().path()).collect();
    seeds.sort();
    let seeds: Vec<Vec<u8>> = seeds.iter().map(|path| std::fs::read(path).unwrap()).collect();
    let mut chance = Chance(salt);
    let mut tally: BTreeMap<String, usize> = BTreeMap::new();
    let (begin, mut slowest) = (Instant::now(), Duration::ZERO);
    let path = folder.path().join("mutated.msh");
    for index in 0..count {
        let bytes = mutate(&seeds[chance.below(seeds.len())], &mut chance);
        std::fs::write(&path, &bytes).unwrap();
        let started = Instant::now();
        let found = std::panic::catch_unwind(|| read(&path));
        slowest = slowest.max(started.elapsed());
        let problem = match found {
            Err(_) => Some("a panic".to_string()),
            Ok(Ok(mesh)) => {
                *tally.entry("read".into()).or_default() += 1;
                (!is_sound(&mesh)).then(|| "a mesh that is not sound".into())
            }
            Ok(Err(error)) => {
                *tally.entry(kind(&error)).or_default() += 1;
                let text = error.to_string();
                (!text.starts_with(&path.display().to_string())).then_some(text)
            }
        };
        if let Some(problem) = problem {
            let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("mutated-{salt}-{index}.msh"));
            std::fs::write(&kept, &bytes).unwrap();
            panic!("{}: {problem}", kept.display());
        }
    }
    let seconds = begin.elapsed().as_secs_f64();
    gmsh::say(&format!("{count} mutated meshes in {seconds:.1} s, slowest {slowest:.1?}: {tally:?}"));
    assert!(slowest < Duration::from_secs(5), "a small file took {slowest:.1?}");
    assert!(tally.len() > 8 && tally.get("read").is_some_and(|n| *n > 0), "the mutations reach too little");
}

/// Name of the refusal, of an element its fault.
fn kind(error: &InputError) -> String {
    let text = match error {
        InputError::MeshElement { fault, .. } => format!("{fault:?}"),
        other => format!("{other:?}"),
    };
    text.split([' ', '(', '{']).next().unwrap_or_default().to_string()
}

#[test]
fn three_thousand_mutated_meshes_are_read_or_refused() {
    fuzz(3_000, 1);
}

#[test]
#[ignore = "long: a hundred thousand files, some minutes"]
fn a_hundred_thousand_mutated_meshes_are_read_or_refused() {
    fuzz(100_000, 2);
}
