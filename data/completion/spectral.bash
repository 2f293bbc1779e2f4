# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# Completes command lines of spectral in bash. Commands, options, their choices and the names of built-in files
# come from the program itself: from `spectral --help`, `spectral COMMAND --help` and `spectral list`.

# Sets `typed` to the words up to the cursor. Bash also splits words at = and :, which are joined here.
_spectral_words() {
    local rest=${COMP_LINE:0:COMP_POINT} blanks word
    typed=()
    for word in "${COMP_WORDS[@]:0:COMP_CWORD+1}"; do
        blanks=${rest%%[![:space:]]*}
        rest=${rest#"$blanks"}
        [[ ${#typed[@]} -gt 0 && -z $blanks ]] || typed+=('')
        [[ $rest == "$word"* ]] || word=$rest # the cursor is inside of the word
        typed[-1]+=$word
        rest=${rest#"$word"}
    done
    current=$word
    [[ $current != [=:] ]] || current=
}

# Prints the names of a list, and the words with which a sampling begins: box:N becomes box:
_spectral_names() {
    "$program" list "$@" 2>/dev/null | sed -n 's/^  \([^ ,]*\)$/\1/p
        s/^  \([a-z]*:\)[A-Z].*/\1/p; s/^  \([a-z]*\), \([a-z]*\)  .*/\1\n\2/p'
}

# Prints the commands, or the options and the operands of a command, with their values.
_spectral_help() {
    "$program" "$@" --help 2>/dev/null
}

# Adds to `found` the words behind $1 that begin with what is typed.
_spectral_add() {
    local known
    for known in $1; do
        [[ $known != "$value"* ]] || found+=("$known")
    done
}

# Adds folders, and the files with one of these endings.
_spectral_add_files() {
    local path ending
    compopt -o filenames 2>/dev/null
    while IFS= read -r path; do
        for ending; do
            [[ $path != *"$ending" && ! -d $path ]] || { found+=("$path"); break; }
        done
    done < <(compgen -f -- "${value//\\/}")
}

# Adds what may stand for a word of the usage, such as SCENE or 8|16|float.
_spectral_add_usage() {
    local usage=$1 one
    case $usage in
    N=*)
        [[ $value == *=* ]] || { _spectral_add 1=; return; }
        value=${value#*=} usage=${usage#*=}
        ;;
    esac
    for one in ${usage//|/ }; do
        case $one in
        SPECTRUM*) _spectral_add "$(_spectral_names illuminants)"; _spectral_add_files .csv .txt .sp ;;
        METHOD) _spectral_add "$(_spectral_names samplings)" ;;
        DETECTOR) _spectral_add "$(_spectral_names detectors)"; _spectral_add_files .csv ;;
        NAME | NAME...) _spectral_add "$(_spectral_names)" ;;
        KIND) _spectral_add "$("$program" list 2>/dev/null | sed -n '/^[a-z]/p')" ;;
        SCENE) _spectral_add "$(_spectral_names scenes)"; _spectral_add_files .scene .list ;;
        *STACK* | *.tif) _spectral_add_files .tif .tiff ;;
        *.png) _spectral_add_files .png .tif ;;
        *.html) _spectral_add_files .html .png ;;
        LIST | *FILE*) _spectral_add_files '' ;;
        *[A-Z]*:*) ;;
        [a-z0-9]*) one=${one%%\[*}; [[ $one == *[A-Z]* ]] || _spectral_add "$one" ;;
        esac
    done
}

# Reads the help of the command. Sets `operands`, and `takes`: the value of each option; '' for a flag.
_spectral_read_help() {
    local row word names
    while IFS= read -r row; do
        case $row in
        usage:*)
            row=${row#usage: * * }
            row=${row%%\[-o*}
            row=${row%\[OPTIONS\]}
            read -ra operands <<<"${row//[\[\]]/}"
            ;;
        '  -'*)
            row=${row#  }
            names=()
            for word in ${row%%  *}; do
                case $word in
                -*) names+=("${word%,}"); takes[${word%,}]= ;;
                *)
                    case ${names[*]} in *--detector*) word=${word/NAME/DETECTOR} ;; esac
                    for row in "${names[@]}"; do takes[$row]=$word; done
                    ;;
                esac
            done
            ;;
        esac
    done < <(_spectral_help "$1")
}

# Completes the last of `typed`, which is a word behind the command.
_spectral_command() {
    local -A takes
    local operands=() word previous='' n=-1
    _spectral_read_help "${typed[1]}"
    for word in "${typed[@]:2}"; do # counts the operands before the cursor and at it
        if [[ $previous && ${takes[$previous]-} ]]; then
            previous=''
        else
            previous=$word
            [[ $word == -?* ]] || n=$((n + 1))
        fi
    done
    previous=${typed[-2]}
    value=${typed[-1]}
    if [[ ${takes[$previous]-} ]]; then
        _spectral_add_usage "${takes[$previous]}"
    elif [[ $value == --*=* ]]; then
        previous=${value%%=*}
        value=${value#*=}
        _spectral_add_usage "${takes[$previous]-}"
    elif [[ $value == -* ]]; then
        _spectral_add "${!takes[*]}"
    elif [[ ${operands[n]-} ]]; then
        _spectral_add_usage "${operands[n]}"
    fi
}

_spectral() {
    local program=${1/#\~/$HOME} typed current value found=() known before
    COMPREPLY=()
    type -- "$program" >/dev/null 2>&1 || return
    _spectral_words
    value=${typed[-1]}
    if [[ ${#typed[@]} -gt 2 && ${typed[1]} != help ]]; then
        _spectral_command
    elif [[ $value == -* ]]; then
        _spectral_add '--help --version'
    else
        _spectral_add "$(_spectral_help | sed -n 's/^  \([a-z][a-z]*\) .*/\1/p')"
    fi
    # Bash replaces only what stands behind the last = or :
    before=${value%"$current"}
    for known in "${found[@]}"; do
        [[ $known != *[:=] ]] || compopt -o nospace 2>/dev/null
        COMPREPLY+=("${known#"$before"}")
    done
} && complete -F _spectral spectral
