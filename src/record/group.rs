//! Which channels belong to one recording.

use hati_inputs::records::Channel;

use super::apart::one_shaking;

/// How far two channels may be from square, degrees.
const SQUARE_DEGREES: f64 = 1.0;

/// Channels of one recording along x, y and z, each with the number of the source it came from.
pub type Components = [Option<(usize, Channel)>; 3];

/// Sorts channels into recordings of one to three components, in the order of their first channel.
///
/// Two channels belong together where
/// - station and instrument are the same: network, station, location and what the channel's code says
///   besides its direction (`HN` of `HNE`; `2`, the surface, of KiK-net's `EW2`); without a station code
///   the file must be the same; channels of one file may differ in their location codes;
/// - they are the same quantity at the same step (to 1e-6) and their times overlap; where a start is unknown and
///   the files are two, these have as many samples each and say the same of the event;
/// - their directions are known and differ.
///
/// Two horizontal channels of one instrument or file that point to no axis but stand square to each other are x
/// and y: x the one 90° clockwise of y, seen from above, as east is of north.
///
/// A direction that comes twice cannot be sorted out: then only the channels of one file go together,
/// and where even that leaves it twice each channel stands alone. A channel without direction stands
/// alone as x.
#[must_use]
pub fn group(mut channels: Vec<(usize, Channel)>) -> Vec<Components> {
    stand_square(&mut channels);
    let mut clusters: Vec<Vec<(usize, Channel)>> = vec![];
    for (source, channel) in channels {
        let place = channel
            .axis_hint
            .and_then(|_| clusters.iter_mut().find(|c| c.iter().all(|(_, other)| together(other, &channel))));
        match place {
            Some(cluster) => cluster.push((source, channel)),
            None => clusters.push(vec![(source, channel)]),
        }
    }
    merged_by_file(clusters).into_iter().flat_map(sorted_out).collect()
}

/// Gives oblique pairs their axes; a channel that fits to several others is left alone.
fn stand_square(channels: &mut [(usize, Channel)]) {
    let pair = |a: &Channel, b: &Channel| {
        let oblique = a.axis_hint.is_none() && b.axis_hint.is_none();
        let same =
            a.quantity == b.quantity && (a.dt - b.dt).abs() <= 1e-6 * a.dt && one_shaking(a, b).is_ok();
        let (Some(first), Some(second)) = (a.azimuth(), b.azimuth()) else { return false };
        let turn = (first - second - 90.0 + 180.0).rem_euclid(360.0) - 180.0;
        oblique
            && same
            && (a.file == b.file || instrument(a) == instrument(b))
            && turn.abs() <= SQUARE_DEGREES
    };
    let mut pairs = vec![];
    for x in 0..channels.len() {
        for y in 0..channels.len() {
            if x != y && pair(&channels[x].1, &channels[y].1) {
                pairs.push((x, y));
            }
        }
    }
    let once = |i: usize| pairs.iter().filter(|(x, y)| *x == i || *y == i).count() == 1;
    for &(x, y) in pairs.iter().filter(|(x, y)| once(*x) && once(*y)) {
        channels[x].1.axis_hint = Some(0);
        channels[y].1.axis_hint = Some(1);
    }
}

/// Puts the clusters of one file together that differ in their location code only, as formats with numbered
/// channels give them, where then each direction comes once.
fn merged_by_file(clusters: Vec<Vec<(usize, Channel)>>) -> Vec<Vec<(usize, Channel)>> {
    let mut left: Vec<Option<Vec<(usize, Channel)>>> = clusters.into_iter().map(Some).collect();
    let mut merged = vec![];
    for first in 0..left.len() {
        let Some(mut whole) = left[first].take() else { continue };
        let family: Vec<usize> = (first + 1..left.len())
            .filter(|&i| left[i].as_ref().is_some_and(|other| of_one_file(&whole, other)))
            .collect();
        let others = family.iter().filter_map(|&i| left[i].as_ref()).flatten();
        if each_direction_once(whole.iter().chain(others)) {
            whole.extend(family.into_iter().filter_map(|i| left[i].take()).flatten());
        }
        merged.push(whole);
    }
    merged
}

fn of_one_file(a: &[(usize, Channel)], b: &[(usize, Channel)]) -> bool {
    let (first, second) = (&a[0].1, &b[0].1);
    let parts = |c: &Channel| -> (String, String) {
        let mut parts = c.id.split('.');
        let station = format!("{}.{}", parts.next().unwrap_or(""), parts.next().unwrap_or(""));
        (station, without_direction(parts.nth(1).unwrap_or("")).to_owned())
    };
    a.iter().chain(b).all(|(_, c)| c.file == first.file && c.axis_hint.is_some())
        && parts(first) == parts(second)
        && first.quantity == second.quantity
        && (first.dt - second.dt).abs() <= 1e-6 * first.dt
        && one_shaking(first, second).is_ok()
}

fn together(a: &Channel, b: &Channel) -> bool {
    a.axis_hint.is_some()
        && instrument(a) == instrument(b)
        && a.quantity == b.quantity
        && (a.dt - b.dt).abs() <= 1e-6 * a.dt
        && one_shaking(a, b).is_ok()
}

/// Network, station, location and instrument; the file where there is no station code.
pub(super) fn instrument(channel: &Channel) -> String {
    let (place, code) = channel.id.rsplit_once('.').unwrap_or(("", channel.id.as_str()));
    let station = place.split('.').nth(1).unwrap_or_default();
    let instrument = without_direction(code);
    match station {
        "" => format!("{}\u{0}{place}.{instrument}", channel.file.display()),
        _ => format!("{place}.{instrument}"),
    }
}

/// What a channel code says besides its direction.
pub(super) fn without_direction(code: &str) -> &str {
    let upper = code.to_ascii_uppercase();
    for word in ["EW", "NS", "UD"] {
        if let Some(sensor) = upper.strip_prefix(word)
            && sensor.chars().all(|c| c.is_ascii_digit())
        {
            return &code[word.len()..];
        }
    }
    let seed = code.len() == 3 && code.is_ascii();
    if seed && upper.ends_with(['E', 'N', 'Z', 'X', 'Y']) { &code[..2] } else { "" }
}

fn sorted_out(cluster: Vec<(usize, Channel)>) -> Vec<Components> {
    if each_direction_once(&cluster) {
        return vec![components(cluster)];
    }
    let mut files: Vec<Vec<(usize, Channel)>> = vec![];
    for (source, channel) in cluster {
        match files.iter_mut().find(|f| f[0].1.file == channel.file) {
            Some(file) => file.push((source, channel)),
            None => files.push(vec![(source, channel)]),
        }
    }
    let alone = |file: Vec<(usize, Channel)>| {
        if each_direction_once(&file) {
            vec![components(file)]
        } else {
            file.into_iter().map(|one| components(vec![one])).collect()
        }
    };
    files.into_iter().flat_map(alone).collect()
}

fn each_direction_once<'a>(channels: impl IntoIterator<Item = &'a (usize, Channel)>) -> bool {
    let mut count = [0; 3];
    channels.into_iter().filter_map(|(_, c)| c.axis_hint).for_each(|axis| count[axis] += 1);
    count.iter().all(|n| *n <= 1)
}

fn components(channels: Vec<(usize, Channel)>) -> Components {
    let mut components = [None, None, None];
    for (source, channel) in channels {
        let axis = channel.axis_hint.unwrap_or(0);
        components[axis] = Some((source, channel));
    }
    components
}

#[cfg(test)]
mod tests {
    use super::*;
    use hati_inputs::motion::Quantity;

    fn channel(id: &str, file: &str, axis_hint: Option<usize>, start: Option<f64>) -> (usize, Channel) {
        let channel = Channel {
            id: id.into(),
            file: file.into(),
            format: "SAC",
            start,
            dt: 0.01,
            samples: vec![0.0; 100],
            quantity: Quantity::Acceleration,
            unit_stored: "g".into(),
            axis_hint,
            steps: vec![],
            sha256: String::new(),
        };
        (0, channel)
    }

    fn id(component: &Option<(usize, Channel)>) -> &str {
        component.as_ref().map_or("", |(_, channel)| channel.id.as_str())
    }

    fn ids(groups: &[Components]) -> Vec<[&str; 3]> {
        groups.iter().map(|[x, y, z]| [id(x), id(y), id(z)]).collect()
    }

    #[test]
    fn components_of_one_instrument_go_together_and_no_others() {
        let found = group(vec![
            channel("CI.CLC..HNE", "a", Some(0), Some(0.0)),
            channel("CI.CLC..HLE", "b", Some(0), Some(0.0)),
            channel("CI.CLC..HNZ", "c", Some(2), Some(0.02)),
            channel("CI.TOW..HNN", "d", Some(1), Some(0.0)),
            channel("CI.CLC..HNN", "e", Some(1), Some(500.0)),
        ]);
        assert_eq!(
            ids(&found),
            [
                ["CI.CLC..HNE", "", "CI.CLC..HNZ"],
                ["CI.CLC..HLE", "", ""],
                ["", "CI.TOW..HNN", ""],
                ["", "CI.CLC..HNN", ""],
            ]
        );
    }

    #[test]
    fn borehole_and_surface_are_two_recordings() {
        let found = group(vec![
            channel("BO.S..EW1", "a", Some(0), None),
            channel("BO.S..EW2", "b", Some(0), None),
            channel("BO.S..NS1", "c", Some(1), None),
            channel("BO.S..UD2", "d", Some(2), None),
        ]);
        assert_eq!(ids(&found), [["BO.S..EW1", "BO.S..NS1", ""], ["BO.S..EW2", "", "BO.S..UD2"]]);
    }

    #[test]
    fn without_a_station_only_a_file_holds_channels_together() {
        let found = group(vec![
            channel("...NS", "a", Some(1), None),
            channel("...EW", "a", Some(0), None),
            channel("...EW", "b", Some(0), None),
            channel("...", "c", None, None),
            channel("...", "d", None, None),
        ]);
        assert_eq!(
            ids(&found),
            [["...EW", "...NS", ""], ["...EW", "", ""], ["...", "", ""], ["...", "", ""]]
        );
    }

    #[test]
    fn oblique_channels_that_stand_square_are_x_and_y() {
        use hati_inputs::motion::Step;
        let oblique = |id: &str, azimuth: f64| {
            let (source, mut channel) = channel(id, "v2", None, None);
            let step = Step::new("read", serde_json::json!({}));
            channel.steps = vec![step.with_found(serde_json::json!({ "azimuth_deg": azimuth }))];
            (source, channel)
        };
        let up = || channel("CE.1.02.UP", "v2", Some(2), None);
        let found = group(vec![oblique("CE.1.01.042", 42.0), up(), oblique("CE.1.03.132", 132.0)]);
        assert_eq!(ids(&found), [["CE.1.03.132", "CE.1.01.042", "CE.1.02.UP"]]);
        // West and south; and across north.
        for (x, y) in [(270.0, 180.0), (30.0, 300.0)] {
            let found = group(vec![oblique("CE.1.01.a", y), oblique("CE.1.03.b", x)]);
            assert_eq!(ids(&found), [["CE.1.03.b", "CE.1.01.a", ""]]);
        }
        let skew = group(vec![oblique("CE.1.01.042", 42.0), oblique("CE.1.03.142", 142.0)]);
        assert_eq!(skew.len(), 2);
        let three = [42.0, 132.0, 222.0].map(|azimuth| oblique("CE.1.01.h", azimuth));
        assert_eq!(group(three.into()).len(), 3);
    }

    #[test]
    fn a_direction_that_comes_twice_is_not_guessed() {
        let twice = group(vec![
            channel("A.B..HNE", "raw", Some(0), Some(0.0)),
            channel("A.B..HNN", "raw", Some(1), Some(0.0)),
            channel("A.B..HNE", "processed", Some(0), Some(0.0)),
            channel("A.B..HNN", "processed", Some(1), Some(0.0)),
        ]);
        assert_eq!(ids(&twice), [["A.B..HNE", "A.B..HNN", ""]; 2]);
        let numbered = group(vec![
            channel("CE.36456.01.090", "v2", Some(0), None),
            channel("CE.36456.02.UP", "v2", Some(2), None),
            channel("CE.36456.03.360", "v2", Some(1), None),
        ]);
        assert_eq!(ids(&numbered), [["CE.36456.01.090", "CE.36456.03.360", "CE.36456.02.UP"]]);
        let building = group(vec![
            channel("A.B.01.E", "one", Some(0), None),
            channel("A.B.01.N", "one", Some(1), None),
            channel("A.B.01.X", "one", Some(0), None),
        ]);
        assert_eq!(building.len(), 3);
    }
}
