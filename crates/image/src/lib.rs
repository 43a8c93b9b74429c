//! Finished pixels: pictures, codecs, tone mapping, error metrics.
