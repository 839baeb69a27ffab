//! What the source documents describe, and what canbaud makes of it.
