//! Which channel of a file serves as a component.

use super::{Channel, Source};
use crate::error::InputError;
use crate::motion::AXES;

/// The channel of a file that serves as the component `axis` (0 = x, 1 = y, 2 = z).
///
/// The one that the source names; without a name the only one of the file, or of several the one whose
/// [`Channel::axis_hint`] is that axis.
///
/// Errors: [`InputError::ChannelMissing`] where none or more than one remains.
pub fn choose(mut channels: Vec<Channel>, source: &Source, axis: usize) -> Result<Channel, InputError> {
    let candidates: Vec<usize> = match &source.channel {
        Some(_) => (0..channels.len()).collect(),
        None if channels.len() == 1 => vec![0],
        None => (0..channels.len()).filter(|&i| channels[i].axis_hint == Some(axis)).collect(),
    };
    if let [only] = candidates[..] {
        return Ok(channels.swap_remove(only));
    }
    let present = channels.iter().map(|c| c.id.clone()).collect::<Vec<_>>().join(", ");
    let wanted = source.channel.clone().unwrap_or_else(|| {
        let axis = AXES.get(axis).copied().unwrap_or_default();
        format!("that is plainly the {axis} component; name one with `channel`")
    });
    Err(InputError::ChannelMissing { path: source.location.clone(), wanted, present })
}
