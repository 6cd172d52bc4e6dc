# Sourced by the scripts of the folders beside it: what they say. $purpose is what remains undone when they skip.

say() { echo "$0: [$SECONDS s] $*" >&2; }

# Says loudly that nothing was tested, and ends with a status that means neither passed nor failed.
skip() {
    cat >&2 <<TEXT

************************************************************************************************
  SKIPPED: $purpose, because $1.
************************************************************************************************

TEXT
    exit 3
}
