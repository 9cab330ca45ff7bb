"""The checksum of every request and reply: x^16 + x^15 + x^2 + 1, reflected, from 0."""

_POLYNOMIAL = 0xA001


def _table_entry(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (_POLYNOMIAL if byte & 1 else 0)
    return byte


_TABLE = tuple(map(_table_entry, range(256)))


def crc16(data: bytes | bytearray) -> int:
    """Return the checksum of `data`; of data with its own checksum behind it, low byte first, it is 0."""
    crc = 0
    for byte in data:
        crc = (crc >> 8) ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc


def crc_text(data: bytes) -> bytes:
    """Return the checksum as it stands behind text: four upper-case digits."""
    return b"%04X" % crc16(data)
