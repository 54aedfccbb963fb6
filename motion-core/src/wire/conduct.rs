use core::fmt;

/// How a message from a host may be treated: what it does, and whether it may be sent again.
///
/// Each row of a host's table states the conduct of its message in brackets. State machines, lint and tools read it from
/// there and nowhere else: what a stop takes out of a queue, what is repeated after a silence, what needs the motors to be
/// known.
///
/// | in the table | purpose |
/// |---|---|
/// | `[asks]` | [`Purpose::Asks`] |
/// | `[sets]`, `[sets once]` | [`Purpose::Sets`] |
/// | `[moves]`, `[moves once]` | [`Purpose::Moves`] |
/// | `[arms]`, `[arms once]` | [`Purpose::Arms`] |
/// | `[stops]` | [`Purpose::Stops`] |
/// | `[resets once]` | [`Purpose::Resets`] |
/// | `[by path]` | the function of this path decides, from the values of the message |
///
/// `once` says that the message is not repeatable. `in sequence`, at the end, says that the message belongs to an exchange
/// of several messages and means nothing alone. `blocks TIME`, at the end, says that the device may hear nothing for this
/// number of milliseconds because of the message.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Conduct {
    /// What the message does.
    pub purpose: Purpose,
    /// Whether sending the message twice is the same as sending it once. Only such a message is sent again when nobody
    /// knows whether it arrived.
    pub repeatable: bool,
    /// Whether the message begins or continues an exchange of several messages, such as an upload or a run.
    pub in_sequence: bool,
    /// Longest time for which the device may hear nothing because of the message, in milliseconds.
    pub blocks: u16,
}

/// What a message from a host does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Purpose {
    /// The message asks for something and changes nothing.
    Asks,
    /// The message changes a setting or an output, or takes a photo. It moves no motor.
    Sets,
    /// A motor may start to move, or change how it moves, because of the message.
    Moves,
    /// The message prepares a motion that a later message, or an operator, starts. The device may move motors to where
    /// that motion begins.
    Arms,
    /// The message stops motors.
    Stops,
    /// The device starts anew or takes another address: for some time it does not answer, and what was known of it may no
    /// longer hold.
    Resets,
}

impl Conduct {
    /// Conduct of a message without a type of its own: it may move a motor, and must not be repeated.
    pub const UNKNOWN: Self = Self::new(Purpose::Moves).once();

    /// Conduct of a repeatable message with this purpose.
    #[must_use]
    pub const fn new(purpose: Purpose) -> Self {
        Self { purpose, repeatable: true, in_sequence: false, blocks: 0 }
    }

    /// The same conduct, not repeatable.
    #[must_use]
    pub const fn once(self) -> Self {
        Self { repeatable: false, ..self }
    }

    /// The same conduct, as part of an exchange of several messages.
    #[must_use]
    pub const fn in_sequence(self) -> Self {
        Self { in_sequence: true, ..self }
    }

    /// The same conduct, of a message because of which the device may hear nothing for this number of milliseconds.
    #[must_use]
    pub const fn blocks(self, blocks: u16) -> Self {
        Self { blocks, ..self }
    }

    /// Whether a motor may move because of the message. After a stop, no such message leaves a queue.
    #[must_use]
    pub const fn may_move(self) -> bool {
        matches!(self.purpose, Purpose::Moves | Purpose::Arms)
    }

    /// Whether the message stops motors: it goes out before everything else.
    #[must_use]
    pub const fn is_stop(self) -> bool {
        matches!(self.purpose, Purpose::Stops)
    }
}

impl fmt::Display for Conduct {
    /// Writes the conduct as the tables do, such as `moves once, in sequence`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.purpose {
            Purpose::Asks => "asks",
            Purpose::Sets => "sets",
            Purpose::Moves => "moves",
            Purpose::Arms => "arms",
            Purpose::Stops => "stops",
            Purpose::Resets => "resets",
        })?;
        f.write_str(if self.repeatable { "" } else { " once" })?;
        f.write_str(if self.in_sequence { ", in sequence" } else { "" })?;
        if self.blocks > 0 { write!(f, ", blocks {}", self.blocks) } else { Ok(()) }
    }
}

impl fmt::Debug for Conduct {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Conduct({self})")
    }
}

/// Turns the words in the brackets of a row into a [`Conduct`].
#[doc(hidden)]
#[macro_export]
macro_rules! __conduct {
    // What the row says of every message of its kind, as an `Option`: `None` where there are no words.
    (row []) => { None };
    (row [by $decide:path]) => { None };
    (row [$($words:tt)+]) => { Some($crate::__conduct!(words $($words)+)) };
    // What it says of this message.
    (of $message:ident []) => {{
        let _ = $message;
        None
    }};
    (of $message:ident [by $decide:path]) => { Some($decide($message)) };
    (of $message:ident [$($words:tt)+]) => {{
        let _ = $message;
        Some($crate::__conduct!(words $($words)+))
    }};
    (words $purpose:ident $($once:ident)?) => { $crate::__conduct!(once $purpose $($once)?) };
    (words $purpose:ident $($once:ident)?, in sequence) => { $crate::__conduct!(once $purpose $($once)?).in_sequence() };
    (words $purpose:ident $($once:ident)?, blocks $time:literal) => {
        $crate::__conduct!(once $purpose $($once)?).blocks($time)
    };
    (once $purpose:ident) => { $crate::wire::Conduct::new($crate::__conduct!(purpose $purpose)) };
    (once $purpose:ident once) => { $crate::wire::Conduct::new($crate::__conduct!(purpose $purpose)).once() };
    (purpose asks) => { $crate::wire::Purpose::Asks };
    (purpose sets) => { $crate::wire::Purpose::Sets };
    (purpose moves) => { $crate::wire::Purpose::Moves };
    (purpose arms) => { $crate::wire::Purpose::Arms };
    (purpose stops) => { $crate::wire::Purpose::Stops };
    (purpose resets) => { $crate::wire::Purpose::Resets };
}
