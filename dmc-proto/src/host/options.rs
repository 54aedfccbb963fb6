//! Options of a host: its timeouts, and how much it does at once.

/// Greatest number of requests under way at once.
pub const MAX_WINDOW: usize = 4;

/// Number of times that a request is sent at most (safety decision 3), and a stop before the application is told (safety
/// decision 1).
pub(super) const TRIES: u8 = 3;

/// Number of times that a greeting is sent before the device counts as silent (DMC D5).
pub(super) const GREETINGS: u8 = 5;

/// Time after a run should be over until the host asks whether it is, in milliseconds.
pub(super) const PATIENCE: u64 = 5000;

/// Time that a shot takes besides its exposure, until the host asks whether it is over, in milliseconds. Some devices take a
/// second before the exposure and a second after it, and report no end (decision D-68).
pub(super) const SHOT: u64 = 2300;

/// Number of zero bytes that complete a frame that was cut off: as many as the longest frame has (decision D-71).
pub(super) const PADDING: u16 = 2048;

/// Greatest number of zero bytes in one piece. The piece fits into the buffer for a frame.
pub(super) const PADDING_PIECE: u16 = 1024;

motion_core::options! {
    /// Options of a host.
    pub struct Options {
        /// Number of requests that may be under way at once, 1 to [`MAX_WINDOW`].
        ///
        /// The vendor's firmware takes one request at a time and may drop an answer (DMC D5).
        window with_window: u8 = 1, in 1..=4;
        /// Id of the first message, from 1 on.
        ///
        /// Draw it at random. Otherwise an answer that waits on the line since an earlier session can have the id of a stop
        /// of this session, and confirm a stop that the device never received (decision D-72). This crate has no source of
        /// random numbers.
        first_id with_first_id: u32 = 1, in 1..=u32::MAX;
        /// Whether requests are held back that the device would refuse, going by its greeting.
        gates with_gates: bool = true;
        /// Speed of the line, in bits per second. It limits how many zero bytes are sent after a greeting or a stop that was
        /// not answered: no more than the line carries until the next try, and in the [timeout of a
        /// stop](Self::stop_timeout) (decision D-71).
        ///
        /// A stop that is sent meanwhile waits for these bytes: 178 ms at 115 200 bits per second, and 250 ms on a slow
        /// line. A slow line carries fewer bytes in that time, 240 at 9600 bits per second. Then it can take several
        /// greetings until a device hears again.
        line_speed with_line_speed: u32 = 115_200, in 1..=u32::MAX;
        /// Whether moves are held back of motors that no `MotorConfigure` has enabled on this link, and shots of motors that
        /// it has not set to blur. Motions along an uploaded move are also held back until all other motors are disabled.
        ///
        /// Devices acknowledge a move of a motor that is not enabled, tell that it arrives, and do not move it (decision
        /// D-76). They move an enabled motor that is not in the uploaded move to 0 (decision D-84). Moves along a move are
        /// held back too after an upload that is not complete (decision D-90).
        ///
        /// Moves and jogs of virtual motors are not checked, because only the device knows which motors they move.
        needs_enabled with_needs_enabled: bool = true;
        /// Time to wait for the answer to a greeting, in milliseconds.
        ///
        /// Boards that are reset when the link is opened need more than two seconds; five greetings cover that (DMC D5).
        greeting_timeout with_greeting_timeout: u32 = 1000, in 1..=u32::MAX;
        /// Time to wait for the answer to a request, in milliseconds. At 115 200 baud, the longest frame takes 91 ms.
        request_timeout with_request_timeout: u32 = 500, in 1..=u32::MAX;
        /// Time to wait for the answer to a stop, and to the question whether motors rest after it, in milliseconds.
        stop_timeout with_stop_timeout: u32 = 250, in 1..=u32::MAX;
        /// Time from an answer of `ERR_CHECKSUM` to the next try, and between two questions whether motors still move, in
        /// milliseconds.
        ///
        /// The default is the time of the longest frame (safety decision 3).
        pause with_pause: u32 = 100, in 1..=u32::MAX;
        /// Time to wait for motors to come to rest in a sequence, in milliseconds. After it the sequence ends without
        /// confirmation.
        travel_timeout with_travel_timeout: u32 = 600_000, in 1..=u32::MAX;
    }
}
