//! Recordings of motion: units, times, periods, people in one file.
