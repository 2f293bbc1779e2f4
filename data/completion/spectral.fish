# SPDX-License-Identifier: MIT
# Completes command lines of spectral in fish. Commands, options, their choices and the names of built-in files
# come from the program itself: from `spectral --help`, `spectral COMMAND --help` and `spectral list`.

# Prints the names of a list, and the words with which a sampling begins: box:N becomes box:
function __spectral_names --argument-names program kind
    $program list $kind 2>/dev/null | sed -n 's/^  \([^ ,]*\)$/\1/p
        s/^  \([a-z]*:\)[A-Z].*/\1/p; s/^  \([a-z]*\), \([a-z]*\)  .*/\1\n\2/p'
end

# Prints folders, and the files with one of the endings.
function __spectral_files --argument-names word
    for path in (__fish_complete_path $word)
        for ending in / $argv[2..]
            string match --quiet "*$ending" -- (string split --max 1 \t -- $path)[1]
            and echo $path
        end
    end
end

# Prints what may stand for a word of the usage, such as SCENE or 8|16|float, where `word` is typed.
function __spectral_usage --argument-names program usage word
    set --local before
    if string match --quiet 'N=*' -- $usage
        if not string match --quiet '*=*' -- $word
            echo 1=
            return
        end
        set before (string replace --regex '=.*' '=' -- $word)
        set usage (string replace N= '' -- $usage)
        set word (string replace --regex '^[^=]*=' '' -- $word)
    end
    for one in (string split '|' -- $usage)
        switch $one
            case 'SPECTRUM*'
                __spectral_names $program illuminants
                __spectral_files "$word" .csv .txt .sp
            case METHOD
                __spectral_names $program samplings
            case DETECTOR
                __spectral_names $program detectors
                __spectral_files "$word" .csv
            case NAME NAME...
                __spectral_names $program
            case KIND
                $program list 2>/dev/null | string match --regex '^[a-z].*'
            case SCENE
                __spectral_names $program scenes
                __spectral_files "$word" .scene .list
            case '*STACK*' '*.tif'
                __spectral_files "$word" .tif .tiff
            case '*.png'
                __spectral_files "$word" .png .tif
            case '*.html'
                __spectral_files "$word" .html .png
            case LIST '*FILE*'
                __spectral_files "$word" ''
            case '*'
                string replace --regex '\[.*' '' -- $one | string match --regex --invert '[A-Z]'
        end
    end | string replace --regex -- '^' "$before"
end

# Prints the value of an option of a command, as its help shows it.
function __spectral_value --argument-names program command option
    set --local usage ($program $command --help 2>/dev/null | string match --regex -- "^  (?:-\S+, )*$option(?:,| ).*")
    set usage (string replace --regex '^  (.*?)(?:  .*)?$' '$1' -- $usage[1])
    string match --quiet '*--detector*' -- $usage; and set usage (string replace NAME DETECTOR -- $usage)
    string match --regex '[^ ]+$' -- $usage | string match --invert -- '-*'
end

function __spectral_complete
    set --local word (commandline --current-token --cut-at-cursor)
    set --local words (commandline --tokenize --cut-at-cursor --current-process)
    set --local program $words[1]
    set --local command $words[2]
    if test (count $words) -eq 1; or test "$words[2..]" = help
        string match --quiet -- '-*' $word; and printf '%s\n' --help --version
        $program --help 2>/dev/null | string match --groups-only --regex '^  ([a-z]+) '
        return
    end
    set --local previous $words[-1]
    if test (count $words) -gt 2; and set --local value (__spectral_value $program $command $previous)
        __spectral_usage $program $value "$word"
    else if string match --quiet -- '--*=*' $word
        set --local parts (string split --max 1 = -- $word)
        __spectral_usage $program (__spectral_value $program $command $parts[1]) "$parts[2]" |
            string replace --regex -- '^' "$parts[1]="
    else if string match --quiet -- '-*' $word
        $program $command --help 2>/dev/null | string match --regex '^  -.*' |
            string replace --regex '^  (.*?)(?:  .*)?$' '$1' | string split ' ' |
            string match -- '-*' | string trim --chars ,
    else
        set --local n 0
        set --local skip
        for one in $words[3..] "$word"
            if test -n "$skip"
                set skip
            else if string match --quiet -- '-?*' $one
                set skip (__spectral_value $program $command $one)
            else
                set n (math $n + 1)
            end
        end
        set --local operands ($program $command --help 2>/dev/null |
            string match --groups-only --regex '^usage: \S+ \S+ (.*?)(?:\[-o.*)?\[OPTIONS\]$' |
            string replace --all --regex '[][]' '' | string split --no-empty ' ')
        test $n -le (count $operands); and __spectral_usage $program $operands[$n] "$word"
    end
end

complete --command spectral --no-files --arguments '(__spectral_complete)'
