//! Reads logic analyser and oscilloscope captures as streams of edges, in bounded memory.
#![forbid(unsafe_code)]
