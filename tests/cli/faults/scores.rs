//! Results that may not depend on what else is asked for.
