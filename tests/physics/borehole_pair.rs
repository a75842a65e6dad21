//! A borehole and a surface record through a known profile, where the collection of records is at hand.

use crate::shared;
use hati::verify::{pair_profile, surface_from_within};
use hati_inputs::records::{ReadOptions, Source, read_many};

/// The collection's pair was made with G(1 + 2iD), periodic over its 60 s, and stored in counts: what is left
/// is the rounding.
#[test]
fn surface_record_from_the_borehole_record() {
    let Some(folder) = shared("records/fixtures_cc0") else { return };
    let profile = pair_profile();
    let table = std::fs::read_to_string(folder.join("SYNH01_profile.csv")).unwrap();
    let rows = table.lines().skip(2).map(|line| line.split(',').map(|x| x.parse::<f64>().unwrap()).collect());
    let rows: Vec<Vec<f64>> = rows.collect();
    for (row, layer) in rows.iter().zip(&profile.layers) {
        assert_eq!(row[..], [layer.thickness, layer.vs, layer.rho, layer.damping_s]);
    }
    for component in ["EW", "NS"] {
        let source = |end| Source::new(folder.join(format!("SYNH013001020304.{component}{end}")));
        let files = read_many(&[source(1), source(2)], &ReadOptions::default()).unwrap();
        // The digitiser's offset, from the quiet first second.
        let centred = |channel: &hati_inputs::records::Channel| -> Vec<f64> {
            let offset = channel.samples[..100].iter().sum::<f64>() / 100.0;
            channel.samples.iter().map(|value| value - offset).collect()
        };
        let (borehole, surface) = (centred(&files[0][0]), centred(&files[1][0]));
        let found = surface_from_within(&profile, 0, &borehole, files[0][0].dt);
        let wrong: f64 = found.iter().zip(&surface).map(|(a, b)| (a - b).powi(2)).sum();
        let error = (wrong / surface.iter().map(|b| b * b).sum::<f64>()).sqrt();
        println!("{component}: surface from borehole, relative L2 {error:.1e}");
        assert!(error <= 1e-4, "{component}: {error}");
    }
}
