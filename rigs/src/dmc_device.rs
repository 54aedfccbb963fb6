//! A DMC device: a rig of motors in steps, and its operator.
