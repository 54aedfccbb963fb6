//! The times that a host keeps, and how much it does at once.

/// Requests on their way at once, at most.
pub const MAX_WINDOW: usize = 4;

/// How often a request is sent at most (safety decision 3), and a stop before the application is told (safety decision
/// 1).
pub(super) const TRIES: u8 = 3;

/// How often a greeting is sent before the device counts as silent (DMC D5).
pub(super) const GREETINGS: u8 = 5;

/// The least that [`Options::with_last_id`] takes: four times as many ids as can be on their way at once.
const LEAST_LAST_ID: u32 = 64;

/// How a host behaves. All times are in milliseconds, and at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Options {
    pub(super) window: u8,
    pub(super) is_gated: bool,
    pub(super) last_id: u32,
    pub(super) times: Times,
}

/// What a host waits for, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Times {
    /// For the answer to a greeting: 1000. Boards that are reset when the line is opened need more than two seconds, five
    /// greetings cover that (DMC D5).
    pub greeting: u32,
    /// For the answer to a request: 500. At 115 200 baud, the longest frame takes 91 ms.
    pub request: u32,
    /// For the answer to a stop, and to the question whether it was obeyed: 250.
    pub stop: u32,
    /// From an answer of `ERR_CHECKSUM` to the next try, and between two questions whether motors still move: 100, which is
    /// the time of the longest frame (safety decision 3).
    pub pause: u32,
    /// For motors to come to rest, when a sequence waits for that: ten minutes. Then it has failed.
    pub travel: u32,
}

/// After the time that a run or a shot should take, until it is asked whether it is over, in milliseconds.
pub(super) const PATIENCE: u64 = 5000;

impl Options {
    /// The same, with up to this many requests on their way at once, 1 to [`MAX_WINDOW`]; 1 unless told otherwise, since
    /// the vendor's firmware takes one request at a time and may drop an answer (DMC D5).
    #[must_use]
    pub fn with_window(mut self, requests: u8) -> Self {
        self.window = requests.clamp(1, 4);
        self
    }

    /// The same, sending also what the device would refuse, going by what it says of itself. By default it is not sent.
    #[must_use]
    pub const fn without_gates(mut self) -> Self {
        self.is_gated = false;
        self
    }

    /// The same, counting ids from 1 to this, then from 1 again: at least 64, and all that there are unless told otherwise.
    /// Few ids keep the number of states small, where these are explored.
    #[must_use]
    pub fn with_last_id(mut self, last: u32) -> Self {
        self.last_id = last.max(LEAST_LAST_ID);
        self
    }

    /// The same, with other times; 0 counts as 1.
    #[must_use]
    pub fn with_times(mut self, times: Times) -> Self {
        let Times { greeting, request, stop, pause, travel } = times;
        let [greeting, request, stop, pause, travel] = [greeting, request, stop, pause, travel].map(|time| time.max(1));
        self.times = Times { greeting, request, stop, pause, travel };
        self
    }
}

impl Default for Times {
    fn default() -> Self {
        Self { greeting: 1000, request: 500, stop: 250, pause: 100, travel: 600_000 }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self { window: 1, is_gated: true, last_id: u32::MAX, times: Times::default() }
    }
}
