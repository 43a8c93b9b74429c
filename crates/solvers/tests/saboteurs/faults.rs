//! The faults of a saboteur, listed once.

/// Makes of a list of faults the enum, with the control before them, and the array of all but the control.
macro_rules! faults {
    ($($(#[doc = $doc:literal])+ $fault:ident,)+) => {
        /// What may be wrong.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Fault {
            /// The control.
            Faultless,
            $($(#[doc = $doc])+ $fault,)+
        }

        use Fault::*;

        /// All but the control.
        pub const FAULTS: [Fault; [$(stringify!($fault)),+].len()] = [$($fault),+];
    };
}
