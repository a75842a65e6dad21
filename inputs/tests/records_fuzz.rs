//! Mutated record files over all readers: every one is read or refused; nothing crashes, hangs or runs code.

mod chance;
mod python;

use chance::Chance;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hati_inputs::InputError;
use hati_inputs::records::{Channel, Limits, ReadOptions, Response, Source, Unit, read_each};

/// Files handed to one reader process.
const BATCH: usize = 250;
/// Largest seed, bytes: more of the same lines tells a reader nothing new.
const SEED_BYTES: u64 = 70_000;

/// Words that readers of text trip over.
const WORDS: [&[u8]; 18] = [
    b"NaN",
    b"inf",
    b"********",
    b"1e400",
    b"-",
    b"1,5",
    b"99999999999",
    b"-1",
    b"0",
    b"NPTS=",
    b"DT=",
    b"\r",
    b"\n\n",
    b"\0",
    b"\xff\xfe",
    b"#",
    b";",
    b"1.0D+05",
];

/// One to four changes: bits, bytes, words, blocks taken out, doubled or moved, the end cut off, digits.
fn mutate(seed: &[u8], chance: &mut Chance) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=chance.below(4) {
        // Headers decide: half of the changes fall into the first kilobyte.
        let span = if chance.below(2) == 0 { bytes.len().min(1024) } else { bytes.len() };
        let at = chance.below(span);
        let scale = chance.below(10);
        let length = 1 + chance.below(1 << scale);
        let end = (at + length).min(bytes.len());
        match chance.below(9) {
            _ if bytes.is_empty() => bytes.push(chance.next() as u8),
            0 => bytes[at] ^= 1 << chance.below(8),
            1 => bytes[at] = chance.next() as u8,
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let block = bytes[at..end].to_vec();
                let to = chance.below(bytes.len());
                bytes.splice(to..to, block);
            }
            5 => {
                let word = WORDS[chance.below(WORDS.len())];
                bytes.splice(at..at, word.iter().copied());
            }
            6 => {
                let word = WORDS[chance.below(WORDS.len())];
                let end = (at + word.len()).min(bytes.len());
                bytes.splice(at..end, word.iter().copied());
            }
            7 => {
                if let Some(digit) = bytes[at..].iter().position(u8::is_ascii_digit) {
                    bytes[at + digit] = b'0' + chance.below(10) as u8;
                }
            }
            _ => bytes[at..end].iter_mut().for_each(|byte| *byte = chance.next() as u8),
        }
    }
    bytes
}

/// Every small sound or broken fixture, and the collection beside the workspace where there is one.
///
/// The hostile ones are made for this test alone: others open a pickle on purpose and leave its mark.
fn seeds(own: &Path) -> Option<Vec<(PathBuf, Vec<u8>)>> {
    let mut folders =
        vec![python::made_by("make_fixtures_text.py")?, python::made_by("make_fixtures_response.py")?];
    let shared = std::env::var_os("HATI_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    if shared.join("records").is_dir() {
        folders.push(shared.join("records"));
    } else {
        python::say("the collection of records is not at hand (HATI_SHARED or ../shared): fixtures alone");
    }
    let mut seeds = Vec::new();
    std::fs::create_dir_all(own).unwrap();
    python::make("make_fixtures.py", own, own);
    folders.push(own.to_path_buf());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.metadata().unwrap().len() <= SEED_BYTES {
                let content = std::fs::read(&path).unwrap();
                seeds.push((path, content));
            }
        }
    }
    seeds.sort();
    Some(seeds)
}

/// What a result may be: sound channels, or a refusal that names the file and was foreseen.
fn judge(path: &Path, found: &Result<Vec<Channel>, InputError>) -> Result<String, String> {
    match found {
        Ok(channels) => {
            for channel in channels {
                let finite =
                    channel.samples.len() > 1 && channel.samples.iter().all(|value| value.is_finite());
                let timed = channel.dt.is_finite() && channel.dt > 0.0;
                let named = channel.start.is_none_or(f64::is_finite);
                if !(finite && timed && named) {
                    return Err(format!("unsound channel {} with dt = {}", channel.id, channel.dt));
                }
            }
            Ok("read".into())
        }
        Err(error @ (InputError::ReaderFailed { .. } | InputError::ReaderTimeout { .. })) => {
            Err(error.to_string())
        }
        Err(error) => {
            let text = error.to_string();
            if !text.starts_with(&path.display().to_string()) {
                return Err(format!("a refusal that does not begin with the file: {text}"));
            }
            let kind = format!("{error:?}");
            Ok(kind.split([' ', '(', '{']).next().unwrap_or_default().to_string())
        }
    }
}

fn fuzz(count: usize, salt: u64) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{salt}-{}", std::process::id()));
    let Some(seeds) = seeds(&folder.join("seeds")) else { return };
    let metadata = python::made_by("make_fixtures_response.py").unwrap().join("station.xml");
    let mut chance = Chance(salt);
    let mut tally: BTreeMap<String, usize> = BTreeMap::new();
    let (begin, mut done, mut slowest) = (Instant::now(), 0, Duration::ZERO);
    while done < count {
        let batch: Vec<(Source, &PathBuf)> = (0..BATCH.min(count - done))
            .map(|i| {
                let (seed, content) = &seeds[chance.below(seeds.len())];
                let path = folder.join(format!("{i}"));
                std::fs::write(&path, mutate(content, &mut chance)).unwrap();
                let mut source = Source::new(path);
                // With a unit, a step or metadata a reader goes further than without.
                match chance.below(8) {
                    0..4 => source.unit = Some(Unit::Gal),
                    4 => (source.unit, source.dt) = (Some(Unit::G), Some(0.02)),
                    5 => source.response = Some(Response::new(&metadata)),
                    _ => {}
                }
                (source, seed)
            })
            .collect();
        let sources: Vec<Source> = batch.iter().map(|(source, _)| source.clone()).collect();
        let limits = Limits { samples: 2_000_000, ..Limits::default() };
        let started = Instant::now();
        let found = read_each(&sources, &ReadOptions { limits, ..ReadOptions::default() }).unwrap();
        slowest = slowest.max(started.elapsed());
        for ((source, seed), result) in batch.iter().zip(&found) {
            match judge(&source.location, result) {
                Ok(kind) => *tally.entry(kind).or_default() += 1,
                Err(problem) => {
                    let kept = folder.with_extension("bad");
                    std::fs::copy(&source.location, &kept).unwrap();
                    panic!("{}, made from {}: {problem}", kept.display(), seed.display());
                }
            }
        }
        done += batch.len();
    }
    assert!(!folder.join("seeds/marker").exists(), "code of a pickle was run");
    std::fs::remove_dir_all(&folder).unwrap();
    let seconds = begin.elapsed().as_secs_f64();
    python::say(&format!(
        "{done} mutated files of {} seeds in {seconds:.0} s, slowest batch {slowest:.1?}: {tally:?}",
        seeds.len()
    ));
    assert_eq!(tally.get("ReaderCrashed"), None, "a library crashed");
    assert!(tally.len() > 5 && tally.get("read").is_some_and(|n| *n > 0), "the mutations reach too little");
}

#[test]
fn two_thousand_mutated_files_are_read_or_refused() {
    fuzz(2_000, 1);
}

#[test]
#[ignore = "long: a hundred thousand files, some minutes"]
fn a_hundred_thousand_mutated_files_are_read_or_refused() {
    fuzz(100_000, 2);
}
