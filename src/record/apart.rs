//! Why channels of one instrument are not one recording, for the user to put right.

use hati_inputs::records::Channel;

use super::Components;
use super::group::instrument;
use crate::results::AXES;

/// What keeps two channels of one instrument apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Apart {
    /// Both times are known and do not overlap: two shakings, nothing to mend.
    Time,
    /// Everything else, in words.
    Because(String),
}

/// Whether two channels can be of one shaking.
///
/// Known times must overlap. Where a start is unknown, channels of one file belong together; those of two files
/// must have as many samples each, and whatever the files say of the event must be the same.
pub(super) fn one_shaking(a: &Channel, b: &Channel) -> Result<(), Apart> {
    if let (Some(start_a), Some(start_b)) = (a.start, b.start) {
        let end = |start: f64, c: &Channel| start + c.samples.len() as f64 * c.dt;
        let overlap = start_a < end(start_b, b) && start_b < end(start_a, a);
        return if overlap { Ok(()) } else { Err(Apart::Time) };
    }
    if a.file == b.file {
        return Ok(());
    }
    let (n_a, n_b) = (a.samples.len(), b.samples.len());
    if n_a != n_b {
        return Err(Apart::Because(format!(
            "a start time is unknown, and {n_a} samples stand against {n_b}"
        )));
    }
    if event(a) != event(b) {
        return Err(Apart::Because("a start time is unknown, and the files name different events".into()));
    }
    Ok(())
}

/// What a file says of the event, without the words for a direction.
fn event(channel: &Channel) -> Vec<String> {
    let Some(found) = channel.steps.first().map(|step| &step.found) else { return vec![] };
    let texts = ["title", "event"].into_iter().filter_map(|key| found.get(key)?.as_str());
    let words = texts.flat_map(|text| text.split([' ', ',', ';', '\t']));
    let words = words.map(|word| word.trim_matches(|c: char| !c.is_alphanumeric()).to_uppercase());
    let code = channel.id.rsplit('.').next().unwrap_or_default().to_uppercase();
    words.filter(|word| !word.is_empty() && *word != code && !is_direction(word)).collect()
}

/// A word that tells one component of an event from another: `90`, `N45W`, `UP`, a channel's number.
fn is_direction(word: &str) -> bool {
    const WORDS: [&str; 22] = [
        "E", "N", "W", "S", "Z", "X", "Y", "V", "L", "T", "EW", "NS", "UD", "UP", "DOWN", "DWN", "DN",
        "VERT", "VERTICAL", "LONG", "TRAN", "H",
    ];
    let bearing = || {
        let inner = word.strip_prefix(['N', 'S'])?.strip_suffix(['E', 'W'])?;
        inner.parse::<u16>().ok()
    };
    WORDS.contains(&word)
        || word.parse::<u16>().is_ok_and(|degrees| degrees <= 360)
        || bearing().is_some_and(|degrees| degrees <= 90)
}

/// What is to be said of recordings that stayed apart though their channels are of one instrument, and of those
/// that were put together though no time says so; one list per recording.
pub(super) fn notes(groups: &[Components]) -> Vec<Vec<String>> {
    let all: Vec<Vec<&Channel>> =
        groups.iter().map(|group| group.iter().flatten().map(|(_, channel)| channel).collect()).collect();
    let of = |number: usize| {
        let mut notes: Vec<String> = together_untimed(&all[number]).into_iter().collect();
        let others = (0..all.len()).filter(|other| *other != number);
        let reasons: Vec<(usize, String)> =
            others.filter_map(|other| Some((other, reason(&all[number], &all[other])?))).collect();
        if let Some((other, why)) = reasons.first() {
            let more = match reasons.len() - 1 {
                0 => String::new(),
                more => format!(" (and {more} more)"),
            };
            let (own, stranger) = (listed(&groups[number]), listed(&groups[*other]));
            notes.push(format!(
                "not one recording: {own} and {stranger}{more}: {why}; if they belong together, name the files of x, \
                 y and z in a scene"
            ));
        }
        notes
    };
    (0..all.len()).map(of).collect()
}

/// Axes and files of a recording, one file once.
fn listed(group: &Components) -> String {
    let mut files: Vec<(String, String)> = vec![];
    for (axis, channel) in group.iter().enumerate() {
        let Some((_, channel)) = channel else { continue };
        let file = channel.file.display().to_string();
        match files.iter_mut().find(|(_, known)| *known == file) {
            Some((axes, _)) => axes.push_str(&format!(", {}", AXES[axis])),
            None => files.push((AXES[axis].to_string(), file)),
        }
    }
    files.iter().map(|(axes, file)| format!("{axes} of {file}")).collect::<Vec<_>>().join(", ")
}

/// Why two recordings of one instrument are two; none where there is nothing to say.
fn reason(own: &[&Channel], other: &[&Channel]) -> Option<String> {
    let pairs = || own.iter().flat_map(|a| other.iter().map(move |b| (*a, *b)));
    let pairs = || pairs().filter(|(a, b)| a.file == b.file || instrument(a) == instrument(b));
    let directed = |c: &Channel| c.axis_hint.is_some() || c.azimuth().is_some();
    let (a, b) = pairs().find(|(a, b)| {
        let related = instrument(a) == instrument(b) && directed(a) && directed(b);
        related && one_shaking(a, b) != Err(Apart::Time)
    })?;
    let shared = AXES.iter().enumerate().find(|(axis, _)| {
        let has = |list: &[&Channel]| list.iter().any(|c| c.axis_hint == Some(*axis));
        has(own) && has(other)
    });
    let other_step = (a.dt - b.dt).abs() > 1e-6 * a.dt;
    match (one_shaking(a, b), shared) {
        // Each has its own x: an acceleration beside its velocity, or two events.
        (_, Some(_)) if a.quantity != b.quantity || other_step => None,
        (Err(_), Some(_)) => None,
        _ if a.quantity != b.quantity => Some(format!("{} against {}", a.quantity, b.quantity)),
        _ if other_step => Some(format!("a step of {} s against {} s", a.dt, b.dt)),
        (Err(Apart::Because(why)), None) => Some(why),
        (Ok(()), Some((_, axis))) => Some(format!("the direction {axis} comes twice")),
        _ => None,
    }
}

/// Files without a start that were taken to begin together.
fn together_untimed(channels: &[&Channel]) -> Option<String> {
    let first = channels.first()?;
    let untimed = channels.iter().any(|c| c.start.is_none()) && channels.iter().any(|c| c.file != first.file);
    untimed.then(|| {
        "the files tell no common start: of one station, step and length, they are taken to begin together".into()
    })
}
