"""Figures for signs, five dots wide and seven high."""

import numpy as np

_GLYPHS = {
    "0": "01110 10001 10011 10101 11001 10001 01110", "1": "00100 01100 00100 00100 00100 00100 01110",
    "2": "01110 10001 00001 00110 01000 10000 11111", "3": "01110 10001 00001 00110 00001 10001 01110",
    "4": "00010 00110 01010 10010 11111 00010 00010", "5": "11111 10000 11110 00001 00001 10001 01110",
    "6": "01110 10000 11110 10001 10001 10001 01110", "7": "11111 00001 00010 00100 01000 01000 01000",
    "8": "01110 10001 10001 01110 10001 10001 01110", "9": "01110 10001 10001 01111 00001 00001 01110",
    ".": "00000 00000 00000 00000 00000 00100 00100", "m": "00000 00000 11010 10101 10101 10101 10101",
    " ": "00000 00000 00000 00000 00000 00000 00000",
}


def lettering(text: str, dots: int = 1) -> np.ndarray:
    """The text as an array (7 dots high, 6 a letter wide): 1 where it is inked; each dot `dots` texels wide."""
    letters = [np.array([[int(c) for c in line] + [0] for line in _GLYPHS[letter].split()], np.float32)
               for letter in text]
    return np.kron(np.concatenate(letters, 1)[:, :-1], np.ones((dots, dots), np.float32))
