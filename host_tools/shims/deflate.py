"""A stand-in for MicroPython's `deflate` module under CPython: reading only."""

import zlib
from errno import EINVAL

AUTO, RAW, ZLIB, GZIP = range(4)
_PIECE = 256


class DeflateIO:
    def __init__(self, stream, format=AUTO, wbits=0):
        """`stream` is opened for reading; of the formats only RAW."""
        if format != RAW:
            raise NotImplementedError("only raw deflate streams are read here")
        self._stream = stream
        self._inflater = zlib.decompressobj(-(wbits or 15))

    def close(self):
        """Let go of the stream."""
        self._stream = None

    def readinto(self, buffer):
        """Bytes put into `buffer`: all of it but at the end. Raises OSError if it is no deflate stream, EOFError if it is cut off."""
        view = memoryview(buffer)
        at = 0
        while at < len(view) and not self._inflater.eof:
            data = self._inflater.unconsumed_tail or self._stream.read(_PIECE)
            try:
                made = self._inflater.decompress(data, len(view) - at)
            except zlib.error as error:
                raise OSError(EINVAL, str(error)) from error
            if not data and not made:
                raise EOFError
            view[at : at + len(made)] = made
            at += len(made)
        return at
