//! Writes rows beside the time loop, on a thread of its own.
//!
//! ```text
//! loop ── frame() ─► fill ─► send ──► bounded channel ──► writer: append, sync at least every 4 s
//!   ▲                                                        │
//!   └──────────── empty frames, failures ◄───────────────────┘
//! ```
//!
//! All frames are made at the start and go round; nothing is allocated afterwards. Where the disk is
//! slower than the loop, [`Background::frame`] waits for a frame to come back, and
//! [`Background::waited`] tells for how long it did.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::OutputError;

/// Longest time between two syncs, s; files may be 5 s behind, and writing takes its part.
const SYNC: Duration = Duration::from_secs(4);

/// Where rows go.
pub trait Sink: Send + 'static {
    /// Values of one row.
    fn values(&self) -> usize;

    /// Takes a row; `time` in s.
    ///
    /// # Errors
    /// Whatever keeps it from being written.
    fn append(&mut self, time: f64, values: &[f32]) -> Result<(), OutputError>;

    /// Brings all rows taken to the disk.
    ///
    /// # Errors
    /// Whatever keeps them from it.
    fn sync(&mut self) -> Result<(), OutputError>;
}

/// A row on its way to a sink.
#[derive(Debug)]
pub struct Frame {
    /// Elapsed time, s.
    pub time: f64,
    /// Values as the sink wants them.
    pub values: Vec<f32>,
    sink: usize,
}

enum Message {
    Frame(Frame),
    Flush,
}

enum Answer {
    /// A frame that can be filled again.
    Empty(Frame),
    /// All that was sent before is on the disk.
    Flushed,
    /// A sink failed; nothing more is written to any.
    Failed(OutputError),
}

/// Sinks that are served by a thread of their own.
#[derive(Debug)]
pub struct Background<S> {
    /// `None` once the thread was told to end.
    to: Option<SyncSender<Message>>,
    answers: Receiver<Answer>,
    empty: Vec<Vec<Frame>>,
    thread: Option<JoinHandle<Vec<S>>>,
    failed: bool,
    waited: Duration,
}

impl<S: Sink> Background<S> {
    /// Starts the thread; `frames` (at least 2) are made for every sink.
    ///
    /// # Errors
    /// A system that gives no more threads.
    pub fn start(sinks: Vec<S>, frames: usize) -> Result<Self, OutputError> {
        Self::start_with(sinks, frames, SYNC)
    }

    /// As [`Self::start`], with the longest time between two syncs.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_with(sinks: Vec<S>, frames: usize, sync: Duration) -> Result<Self, OutputError> {
        let frames = frames.max(2);
        let empty: Vec<Vec<Frame>> = (sinks.iter().enumerate())
            .map(|(sink, s)| {
                let one = |_| Frame { time: 0.0, values: vec![0.0; s.values()], sink };
                (0..frames).map(one).collect()
            })
            .collect();
        // Every frame, a flush and a failure find a place: neither side waits for the channel itself.
        let most = frames * sinks.len() + 2;
        let (to, messages) = sync_channel(most);
        let (answer, answers) = sync_channel(most);
        let writer = Writer { sinks, messages, answer, sync, failed: false, unsynced: None };
        let thread = std::thread::Builder::new()
            .name("hati-writer".into())
            .spawn(move || writer.work())
            .map_err(|cause| OutputError::Io { path: "the writer's thread".into(), cause })?;
        let (to, thread) = (Some(to), Some(thread));
        Ok(Self { to, answers, empty, thread, failed: false, waited: Duration::ZERO })
    }

    /// A frame to fill for a sink; waits for one where all are under way.
    ///
    /// # Errors
    /// What a sink failed with since the last call; after that [`OutputError::WriterEnded`].
    ///
    /// # Panics
    /// If there is no such sink.
    pub fn frame(&mut self, sink: usize) -> Result<Frame, OutputError> {
        loop {
            match self.answers.try_recv() {
                Ok(answer) => drop(self.take(answer)?),
                Err(TryRecvError::Disconnected) => return Err(self.ended()),
                Err(TryRecvError::Empty) => break,
            }
        }
        if self.failed {
            return Err(OutputError::WriterEnded);
        }
        let start = Instant::now();
        loop {
            if let Some(frame) = self.empty[sink].pop() {
                return Ok(frame);
            }
            let answer = self.answers.recv().map_err(|_| OutputError::WriterEnded)?;
            let outcome = self.take(answer);
            self.waited += start.elapsed();
            outcome?;
        }
    }

    /// Hands a filled frame over; never waits.
    ///
    /// # Errors
    /// A writer that ended; a failure of a sink is told by the next [`Self::frame`].
    pub fn send(&mut self, frame: Frame) -> Result<(), OutputError> {
        let to = self.to.as_ref().ok_or(OutputError::WriterEnded)?;
        to.send(Message::Frame(frame)).map_err(|_| OutputError::WriterEnded)
    }

    /// Waits until all that was handed over is on the disk: what a checkpoint needs.
    ///
    /// # Errors
    /// As [`Self::frame`].
    pub fn flush(&mut self) -> Result<(), OutputError> {
        if self.failed {
            return Err(OutputError::WriterEnded);
        }
        let to = self.to.as_ref().ok_or(OutputError::WriterEnded)?;
        to.send(Message::Flush).map_err(|_| OutputError::WriterEnded)?;
        loop {
            let answer = self.answers.recv().map_err(|_| OutputError::WriterEnded)?;
            if self.take(answer)? {
                return Ok(());
            }
        }
    }

    /// Waits for all rows, ends the thread and gives the sinks back.
    ///
    /// # Errors
    /// As [`Self::flush`]; the thread is then ended all the same.
    pub fn finish(mut self) -> Result<Vec<S>, OutputError> {
        let flushed = self.flush();
        let sinks = self.join();
        flushed.and(sinks.ok_or(OutputError::WriterEnded))
    }

    /// Time for which the loop waited for the disk.
    #[must_use]
    pub fn waited(&self) -> Duration {
        self.waited
    }

    /// Books an answer; true where it says that a flush is done.
    fn take(&mut self, answer: Answer) -> Result<bool, OutputError> {
        match answer {
            Answer::Empty(frame) => self.empty[frame.sink].push(frame),
            Answer::Flushed => return Ok(true),
            Answer::Failed(error) => {
                self.failed = true;
                return Err(error);
            }
        }
        Ok(false)
    }

    fn ended(&mut self) -> OutputError {
        self.failed = true;
        OutputError::WriterEnded
    }
}

impl<S> Background<S> {
    fn join(&mut self) -> Option<Vec<S>> {
        // Without a sender the thread writes what it has and ends.
        self.to = None;
        self.thread.take()?.join().ok()
    }
}

impl<S> Drop for Background<S> {
    fn drop(&mut self) {
        drop(self.join());
    }
}

/// The other side.
struct Writer<S> {
    sinks: Vec<S>,
    messages: Receiver<Message>,
    answer: SyncSender<Answer>,
    sync: Duration,
    failed: bool,
    /// Since when there are rows that no sync has followed.
    unsynced: Option<Instant>,
}

impl<S: Sink> Writer<S> {
    fn work(mut self) -> Vec<S> {
        loop {
            let due = self.unsynced.map_or(self.sync, |since| self.sync.saturating_sub(since.elapsed()));
            match self.messages.recv_timeout(due) {
                Ok(Message::Frame(frame)) => {
                    if !self.failed {
                        let outcome = self.sinks[frame.sink].append(frame.time, &frame.values);
                        self.unsynced = self.unsynced.or_else(|| Some(Instant::now()));
                        self.note(outcome);
                    }
                    // A loop that has gone away wants no frames back.
                    let _ = self.answer.send(Answer::Empty(frame));
                }
                Ok(Message::Flush) => {
                    self.bring_to_disk();
                    if !self.failed {
                        let _ = self.answer.send(Answer::Flushed);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    self.bring_to_disk();
                    return self.sinks;
                }
            }
            if self.unsynced.is_some_and(|since| since.elapsed() >= self.sync) {
                self.bring_to_disk();
            }
        }
    }

    fn bring_to_disk(&mut self) {
        self.unsynced = None;
        if !self.failed {
            let outcome = self.sinks.iter_mut().try_for_each(Sink::sync);
            self.note(outcome);
        }
    }

    fn note(&mut self, outcome: Result<(), OutputError>) {
        if let Err(error) = outcome {
            self.failed = true;
            let _ = self.answer.send(Answer::Failed(error));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::{Arc, Mutex};

    use super::*;

    /// Times and values.
    type Rows = Arc<Mutex<Vec<(f64, Vec<f32>)>>>;

    /// Keeps what it is given; fails at row `most`; tells how many rows were synced.
    struct Kept {
        rows: Rows,
        synced: Arc<AtomicUsize>,
        most: usize,
        slow: Duration,
    }

    impl Kept {
        fn new(most: usize) -> Self {
            Self { rows: Arc::default(), synced: Arc::default(), most, slow: Duration::ZERO }
        }
    }

    impl Sink for Kept {
        fn values(&self) -> usize {
            3
        }

        fn append(&mut self, time: f64, values: &[f32]) -> Result<(), OutputError> {
            std::thread::sleep(self.slow);
            let mut rows = self.rows.lock().expect("no panic elsewhere");
            if rows.len() == self.most {
                return Err(OutputError::DiskFull { path: "kept".into(), room: None });
            }
            rows.push((time, values.to_vec()));
            Ok(())
        }

        fn sync(&mut self) -> Result<(), OutputError> {
            self.synced.store(self.rows.lock().expect("no panic elsewhere").len(), Ordering::SeqCst);
            Ok(())
        }
    }

    fn give(background: &mut Background<Kept>, sink: usize, number: usize) -> Result<(), OutputError> {
        let mut frame = background.frame(sink)?;
        frame.time = number as f64;
        frame.values.fill(number as f32);
        background.send(frame)
    }

    #[test]
    fn rows_arrive_in_order_and_a_flush_is_a_barrier() {
        let sinks = vec![Kept::new(usize::MAX), Kept::new(usize::MAX)];
        let (rows, synced) = (sinks[1].rows.clone(), sinks[1].synced.clone());
        let mut background = Background::start(sinks, 3).expect("a thread");
        for number in 0..100 {
            give(&mut background, number % 2, number).expect("handed over");
        }
        background.flush().expect("flushed");
        assert_eq!(synced.load(Ordering::SeqCst), 50);
        give(&mut background, 1, 101).expect("handed over");
        let sinks = background.finish().expect("no failure");
        assert_eq!(sinks[0].synced.load(Ordering::SeqCst), 50);
        assert_eq!(synced.load(Ordering::SeqCst), 51);
        let rows = rows.lock().expect("whole");
        let numbers: Vec<usize> = rows.iter().map(|(t, _)| *t as usize).collect();
        assert_eq!(numbers, (0..50).map(|n| 2 * n + 1).chain([101]).collect::<Vec<_>>());
        assert!(rows.iter().all(|(t, v)| v.iter().all(|v| f64::from(*v) == *t)));
    }

    #[test]
    fn a_failure_comes_back_once_and_ends_the_writing() {
        let sink = Kept::new(5);
        let rows = sink.rows.clone();
        let mut background = Background::start(vec![sink], 2).expect("a thread");
        let failure = (0..100).find_map(|n| give(&mut background, 0, n).err()).expect("told");
        assert!(matches!(failure, OutputError::DiskFull { .. }), "{failure}");
        assert!(matches!(background.frame(0), Err(OutputError::WriterEnded)));
        assert!(matches!(background.flush(), Err(OutputError::WriterEnded)));
        assert!(background.finish().is_err());
        assert_eq!(rows.lock().expect("whole").len(), 5);
    }

    #[test]
    fn a_failure_at_the_last_rows_is_not_lost() {
        let mut background = Background::start(vec![Kept::new(1)], 4).expect("a thread");
        for number in 0..2 {
            give(&mut background, 0, number).expect("handed over");
        }
        assert!(matches!(background.finish(), Err(OutputError::DiskFull { .. })));
    }

    #[test]
    fn rows_are_synced_while_the_loop_computes() {
        let sink = Kept::new(usize::MAX);
        let synced = sink.synced.clone();
        let mut background =
            Background::start_with(vec![sink], 2, Duration::from_millis(20)).expect("a thread");
        give(&mut background, 0, 0).expect("handed over");
        let start = Instant::now();
        while synced.load(Ordering::SeqCst) == 0 {
            assert!(start.elapsed() < Duration::from_secs(30), "never synced");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn a_slow_disk_holds_the_loop_back() {
        let mut sink = Kept::new(usize::MAX);
        sink.slow = Duration::from_millis(5);
        let mut background = Background::start(vec![sink], 2).expect("a thread");
        for number in 0..10 {
            give(&mut background, 0, number).expect("handed over");
        }
        assert!(background.waited() >= Duration::from_millis(20), "{:?}", background.waited());
        drop(background);
    }

    #[test]
    fn the_loop_allocates_nothing() {
        /// Takes all and keeps nothing.
        struct Sunk;
        impl Sink for Sunk {
            fn values(&self) -> usize {
                1000
            }
            fn append(&mut self, _: f64, _: &[f32]) -> Result<(), OutputError> {
                Ok(())
            }
            fn sync(&mut self) -> Result<(), OutputError> {
                Ok(())
            }
        }
        let mut background = Background::start(vec![Sunk], 3).expect("a thread");
        let mut round = |count: usize| {
            for _ in 0..count {
                let frame = background.frame(0).expect("a frame");
                background.send(frame).expect("handed over");
            }
        };
        // The first wait makes what a thread needs for waiting.
        round(500);
        let counted = allocation_counter::measure(|| round(500));
        assert_eq!(counted.count_total, 0, "{counted:?}");
    }
}
