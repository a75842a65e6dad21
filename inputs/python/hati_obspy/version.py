"""The version, apart so that a build reads it without importing ObsPy's world."""

VERSION = "0.1.0"
