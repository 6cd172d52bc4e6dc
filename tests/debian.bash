# Sourced by the scripts of the folders beside it: Debian's packages, unpacked into folders of our own below $target.
#
# Neither root nor an installation is needed, and the host's package state is never touched: apt gets folders of its own.
# What was fetched once is used from then on without a network.

# An apt that knows both architectures and of no installed package, so that it names all that is needed. With $suite set it knows
# that release of Debian, from where the system's own comes.
make_private_apt() {
    private_apt=$(mkdir -p "$target/apt${suite:+-$suite}" && cd "$target/apt${suite:+-$suite}" && pwd)
    [ ! -e "$private_apt/complete" ] || return 0
    rm -rf "${private_apt:?}"/* && mkdir -p "$private_apt"/{lists/partial,cache/archives/partial}
    : >"$private_apt/status"
    cat >"$private_apt/apt.conf" <<CONF
Dir::State "$private_apt";
Dir::State::status "$private_apt/status";
Dir::Cache "$private_apt/cache";
Dir::Log "$private_apt";
APT::Architecture "amd64";
APT::Architectures { "amd64"; "arm64"; };
APT::Install-Recommends "false";
APT::Sandbox::User "";
Acquire::Languages "none";
Acquire::Retries "1";
Acquire::http::Timeout "30";
CONF
    [ -z "${suite:-}" ] || use_suite || return 1
    # An update that reaches nothing is a success for apt, so the lists themselves are looked for.
    with_private_apt apt-get -qq update >&2 && ls "$private_apt"/lists/*_Packages* >/dev/null 2>&1 &&
        touch "$private_apt/complete"
}

use_suite() {
    local site
    # shellcheck disable=SC2016
    site=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | sed -n '/\/debian\/$/{p;q}')
    [ -n "$site" ] || return 1
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $site $suite main" >"$private_apt/sources.list"
    cat >>"$private_apt/apt.conf" <<CONF
Dir::Etc::sourcelist "$private_apt/sources.list";
Dir::Etc::sourceparts "$private_apt/none";
CONF
}

with_private_apt() { APT_CONFIG=$private_apt/apt.conf timeout 1200 "$@" </dev/null; }

# with_fresh_lists COMMAND...: once more with lists of today when it fails, because old ones name files that are gone.
with_fresh_lists() {
    make_private_apt || return 1
    "$@" && return
    rm -f "$private_apt/complete"
    make_private_apt && "$@"
}

# fetch_packages FOLDER PACKAGE...: the packages and all that they need, unpacked into the folder. Files of packages that the
# pattern $unwanted matches stay away.
fetch_packages() {
    local folder=$1 package
    shift
    [ "$(cat "$folder/complete" 2>/dev/null)" != "$*" ] || return 0
    say "fetching $* into $folder (once)"
    with_fresh_lists download_with_all_they_need "$folder.packages" "$@" || return 1
    rm -rf "$folder" && mkdir -p "$folder"
    for package in "$folder.packages"/*.deb; do
        # A pattern is meant.
        # shellcheck disable=SC2254
        case $(basename "$package") in
        ${unwanted:-}) ;;
        *) dpkg -x "$package" "$folder" || return 1 ;;
        esac
    done
    rm -rf "$folder.packages" && echo "$*" >"$folder/complete"
}

download_with_all_they_need() {
    local into=$1
    shift
    rm -rf "$into" && mkdir -p "$into/partial"
    with_private_apt apt-get -qq -o Dir::Cache::archives="$into" install --yes --download-only "$@" >&2
}
