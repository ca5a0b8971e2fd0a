// Rules for the shapes of the arguments of a bound function.
//
// A rule such as "3,m n+1 2n m" lists the arguments in order: a matrix with three rows, and three arrays.
// A length is a constant, or a multiple of a letter plus a constant.
// A letter has the same value in all arguments; the first argument with this letter determines the value.
// An integer argument is a letter, which must not be negative, or "<n" for an index below n. "*" is any length,
// any integer, or an argument of another type.
#pragma once
#include <initializer_list>
#include <sstream>

#include "arrays.hpp"

class ShapeRules {
    struct Length {
        char letter = 0;  // 0 for a constant
        Index factor = 1, more = 0;
        bool is_any = false, is_bound = false;
    };
    std::vector<std::vector<Length>> arguments;
    std::vector<std::string> texts;

    static Length parse_length(const std::string& text) {
        Length length;
        std::size_t at = 0;
        const auto number = [&] {
            Index value = 0;
            for (; at < text.size() && '0' <= text[at] && text[at] <= '9'; ++at) value = 10 * value + (text[at] - '0');
            return value;
        };
        if (text[at] == '*') return length.is_any = true, length;
        if (text[at] == '<') length.is_bound = true, ++at;
        const Index first = number();
        if (at == text.size()) return length.more = first, length;
        if (at) length.factor = length.is_bound ? 1 : first;
        length.letter = text[at++];
        if (at < text.size() && text[at] == '+') ++at, length.more = number();
        if (at < text.size()) throw std::logic_error("not a length: " + text);
        return length;
    }

    bool uses_letter(std::size_t argument, char letter) const {
        return texts[argument].find(letter) != std::string::npos;
    }

  public:
    // The sizes bound to the symbols of the shape rules during one call.
    class Call {
        const ShapeRules& rules;
        Index value[128];
        std::size_t argument = 0;

        // Throw an error such as "argument 2 of the core is (3, 5), and not (3,m) with m = 4".
        [[noreturn]] void fail(std::initializer_list<Index> lengths) const {
            std::ostringstream text;
            text << "argument " << argument + 1 << " of the core is (";
            for (std::size_t k = 0; k < lengths.size(); ++k) text << (k ? ", " : "") << lengths.begin()[k];
            text << "), and not (" << rules.texts[argument] << ")";
            const char* joint = " with ";
            for (int letter = 'a'; letter <= 'z'; joint = ", ", ++letter) {
                while (letter <= 'z' && (value[letter] < 0 || !rules.uses_letter(argument, char(letter)))) ++letter;
                if (letter <= 'z') text << joint << char(letter) << " = " << value[letter];
            }
            throw std::invalid_argument(text.str());
        }

        bool fits(const Length& rule, Index length) {
            if (rule.is_any) return true;
            if (!rule.letter) return length == rule.more;
            Index& known = value[std::size_t(rule.letter)];
            if (rule.is_bound) return 0 <= length && length < known;
            const Index rest = length - rule.more;
            if (known < 0 && rest >= 0 && rest % rule.factor == 0) known = rest / rule.factor;
            return known >= 0 && rest == rule.factor * known;
        }

      public:
        explicit Call(const ShapeRules& rules) : rules(rules) { std::fill_n(value, 128, Index(-1)); }

        // Check the lengths of the next argument, or its value if it is an integer.
        void check(std::initializer_list<Index> lengths) {
            const auto& rule = rules.arguments[argument];
            bool good = rule.size() == lengths.size() || rule[0].is_any;
            for (std::size_t k = 0; good && k < lengths.size() && !rule[0].is_any; ++k)
                good = fits(rule[k], lengths.begin()[k]);
            if (!good) fail(lengths);
            ++argument;
        }
    };

    ShapeRules(const char* text, std::size_t count) {
        std::istringstream words(text);
        for (std::string word; words >> word;) {
            arguments.emplace_back(), texts.push_back(word);
            std::istringstream parts(word);
            for (std::string part; std::getline(parts, part, ',');) arguments.back().push_back(parse_length(part));
        }
        if (arguments.size() != count) throw std::logic_error(std::string("not a rule for each argument: ") + text);
    }
};
